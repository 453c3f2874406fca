"""A polyhedron on which a given edge was not found: its residual is infinite, and JSON has no infinity."""

from pathlib import Path

import pytest

import isoembed
import zoo
from isoembed import NotEmbedded, PolyhedralMetric
from isoembed.io import write_metric
from lost_edges import octahedron_with_a_lost_edge
from strict_json import strict


@pytest.fixture
def lost(call, monkeypatch):
    """Let `embed` return such a polyhedron as its best attempt."""

    def embed(metric, **_):
        found = octahedron_with_a_lost_edge()
        raise NotEmbedded(found.message, found)

    write_metric("m.npz", PolyhedralMetric.from_mesh(*zoo.octahedron()))
    monkeypatch.setattr(isoembed, "embed", embed, raising=False)


def test_all_outputs_are_written(call, lost):
    outputs = ("--report", "r.json", "--html", "p.html", "-o", "a.json", "--keep")
    status, _, err = call("embed", "m.npz", "--method", "alexandrov", *outputs)
    assert status == 3
    assert "was not found on the polyhedron" in err
    report = strict(Path("r.json").read_text())
    assert report["status"] == "not converged"
    assert "was not found on the polyhedron" in report["message"]
    assert report["residual"]["max"] is report["residual"]["paths"] is None
    assert "was not found on the polyhedron" in Path("p.html").read_text()
    assert len(strict(Path("a.json").read_text())["vertices"]) == 6


def test_the_summary(call, lost):
    status, out, _ = call("embed", "m.npz", "--method", "alexandrov")
    assert status == 3
    assert "residual    infinite max" in out
