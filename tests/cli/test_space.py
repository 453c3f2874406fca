"""``isoembed embed --space``, and what the other commands make of surfaces in curved spaces."""

from pathlib import Path

import numpy as np
import pytest

import zoo
from isoembed import PolyhedralMetric
from isoembed.cli import batch
from isoembed.io import read_metric, read_surface, write_metric
from isoembed.metric.curvature import area, deficits
from strict_json import strict
from tasks import Here

VERTICES, FACES = zoo.icosphere(1)
BODY = 0.5 * VERTICES * [1.0, 0.9, 0.8]


def written(name, curvature):
    metric = PolyhedralMetric.from_mesh(BODY, FACES, curvature=curvature)
    write_metric(name, metric)
    return metric


@pytest.mark.parametrize(("curvature", "name"), [(-1.0, "hyperbolic"), (0.5, "spherical")])
def test_a_file_says_its_space(call, curvature, name):
    metric = written("m.npz", curvature)
    status, out, err = call("embed", "m.npz", "-o", "s.ply", "--report", "r.json", "--json")
    assert (status, err) == (0, "")
    assert strict(out)["space"] == {"name": name, "curvature": curvature, "model": "conformal"}
    assert strict(Path("r.json").read_text())["space"] == strict(out)["space"]
    surface = read_surface("s.ply")
    assert surface.space == metric.space
    np.testing.assert_allclose(surface.metric.lengths, metric.lengths, rtol=1e-9)
    status, out, _ = call("embed", "s.ply", "--space", name)
    assert status == 0 and f"space       {name}, of curvature {curvature:g}" in out
    status, out, _ = call("inspect", "s.ply", "--json")
    assert strict(out)["space"]["curvature"] == curvature


def test_lengths_on_triangles_of_another_space(call):
    """The lengths of a body in R^3, between which triangles of hyperbolic space are smaller."""
    flat = written("m.npz", 0.0)
    status, out, _ = call("embed", "m.npz", "--space", "hyperbolic=-0.5", "-o", "s.npz", "--json")
    assert status == 0 and strict(out)["space"]["curvature"] == -0.5
    surface = read_surface("s.npz")
    np.testing.assert_allclose(surface.metric.lengths, flat.lengths, rtol=1e-9)
    assert -0.5 * surface.area == pytest.approx(4 * np.pi - deficits(surface.metric).sum(), rel=1e-9)
    assert surface.area < area(flat)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (
            "hyperbolic=1",
            "argument --space: 1 is not the curvature of hyperbolic space, which is negative: hyperbolic=-1",
        ),
        (
            "spherical=-2",
            "argument --space: -2 is not the curvature of spherical space, which is positive: spherical=2",
        ),
        ("hyperbolic=0", "argument --space: 0 is not the curvature of hyperbolic space, which is negative"),
        ("hyperbolic=low", "argument --space: 'low' is not a finite number"),
        ("hyperbolic=-inf", "argument --space: '-inf' is not a finite number"),
        ("flat", "argument --space: 'flat' is not hyperbolic[=K] or spherical[=K]"),
        ("spherical", "m.npz is in hyperbolic space of curvature -1.0, not in spherical space"),
        ("hyperbolic=-2", "m.npz is in hyperbolic space of curvature -1.0, not in that of curvature -2.0"),
    ],
)
def test_what_is_refused(call, option, said):
    written("m.npz", -1.0)
    status, _, err = call("embed", "m.npz", "--space", option)
    assert status == 2 and said in err


def test_a_sphere_needs_its_curvature(call):
    written("m.npz", 0.0)
    status, _, err = call("embed", "m.npz", "--space", "spherical", "-o", "s.ply")
    assert status == 2
    assert "m.npz does not contain the curvature of its space: give it, as in spherical=1" in err


def test_methods_that_embed_in_r3_alone(call):
    written("m.npz", -1.0)
    status, _, err = call("embed", "m.npz", "--method", "paper", "-o", "s.ply")
    assert (
        status == 2
        and "the metric has the curvature -1, and the method 'paper' embeds in Euclidean space" in err
    )


def test_a_metric_that_is_convex_in_r3_is_embedded_there(call):
    written("m.npz", 0.0)
    status, _, err = call("embed", "m.npz", "--space", "hyperbolic", "-o", "s.ply")
    assert status == 0
    assert "it is embedded in R^3; for curvature -1 write --space hyperbolic=-1\n" in err
    assert read_metric("s.ply").curvature == 0.0


def test_many_files(call, monkeypatch):
    monkeypatch.setattr(batch, "Workers", Here)
    metrics = {name: written(f"{name}.npz", k) for name, k in (("a", -1.0), ("b", 0.5), ("c", 0.0))}
    run = ("embed", "--jobs", 1, "--quiet", "a.npz", "b.npz", "c.npz", "-o", "out")
    assert call(*run)[0] == 0
    for name, metric in metrics.items():
        again = read_metric(f"out/{name}.ply")
        assert again.space == metric.space
        np.testing.assert_allclose(again.lengths, metric.lengths, rtol=1e-9)
    assert call(*run, "--space", "hyperbolic")[0] == 3  # of other spaces: b is refused
    assert read_metric("out/a.ply").curvature == -1.0
    assert strict(Path("out/b.json").read_text())["message"].startswith("b.npz is in spherical space")


@pytest.mark.parametrize("ending", [".html", ".png"])
def test_views_say_the_space(call, ending):
    if ending == ".png":
        pytest.importorskip("matplotlib")
    written("m.npz", -1.0)
    assert call("embed", "m.npz", "-o", "s.vtu", "--quiet")[0] == 0
    assert call("view", "s.vtu", "-o", f"v{ending}")[0] == 0
    if ending == ".html":
        assert "hyperbolic space of curvature" in Path("v.html").read_text(encoding="utf-8")


def test_paper_is_flat(call):
    written("m.npz", -1.0)
    assert call("embed", "m.npz", "-o", "s.obj", "--quiet")[0] == 0
    status, _, err = call("unfold", "s.obj", "-o", "n.json")
    assert status == 2 and "the surface is in hyperbolic space" in err
