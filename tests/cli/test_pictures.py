"""``isoembed embed`` and ``glue``: pictures, pages and films beside the surface."""

import json

import pytest

import smooth_bodies
from isoembed import PolyhedralMetric
from isoembed.cli import main
from isoembed.io import write_metric

pytest.importorskip("matplotlib")


@pytest.fixture
def metric(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    vertices, faces = smooth_bodies.ellipsoid(80)
    write_metric("metric.npz", PolyhedralMetric.from_mesh(vertices, faces))
    return "metric.npz"


def test_everything_at_once(metric, tmp_path, capsys):
    asked = ["--html", "p.html", "--animate", "f.gif", "--picture", "c.svg", "--color", "Gaussian curvature"]
    assert main(["embed", metric, "-o", "s.ply", "--method", "paper", "--parameter", "Tsteps=2", *asked]) == 0
    assert {p.name for p in tmp_path.iterdir()} == {"metric.npz", "s.ply", "p.html", "f.gif", "c.svg"}
    assert (tmp_path / "f.gif").read_bytes().startswith(b"GIF89a")
    assert "Gaussian curvature" in (tmp_path / "c.svg").read_text()
    assert "pull back" in (tmp_path / "p.html").read_text()  # the stages
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--picture", "a.gif"], "a.gif has the ending '.gif', not one of .png .svg .pdf"),
        (["-o", "a.pdf"], "and paper nets are written by 'isoembed unfold': did you mean --picture a.pdf?"),
        (["--html", "a.png"], "a.png has the ending '.png', not one of .html"),
        (["--animate", "a.html"], "a.html has the ending '.html', not one of .gif .mp4"),
        (["--color", "residual"], "--color needs a --picture whose colors it chooses"),
        (["--html", "there/a.html"], "cannot write there/a.html: there is no folder "),
        (["--color", "torsion", "--picture", "a.png"], "argument --color: invalid choice: 'torsion'"),
    ],
)
def test_what_is_refused_before_anything_is_computed(metric, tmp_path, capsys, arguments, said):
    assert main(["embed", metric, *arguments]) == 2
    assert said in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["metric.npz"]


def test_failures_are_drawn_only_if_they_are_kept(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _, faces = smooth_bodies.ellipsoid()
    lengths = [1.0] * (3 * len(faces) // 2)
    (tmp_path / "unit.json").write_text(json.dumps({"faces": faces.tolist(), "lengths": lengths}))
    assert main(["embed", "unit.json", "--html", "p.html", "--picture", "c.png"]) == 3
    assert [p.name for p in tmp_path.iterdir()] == ["unit.json"]
    assert main(["embed", "unit.json", "--html", "p.html", "--picture", "c.png", "--keep"]) == 3
    assert {p.name for p in tmp_path.iterdir()} == {"unit.json", "p.html", "c.png"}
    assert "not converged" in (tmp_path / "p.html").read_text()
    assert "isoembed: error: " in capsys.readouterr().err


def test_a_solid_from_paper(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    folded = {"polygons": [[[0, 0], [4, 0], [2, 3]]], "sides": [[[0, k], [0, k]] for k in range(3)]}
    (tmp_path / "net.json").write_text(json.dumps(folded))
    assert main(["glue", "net.json", "--html", "p.html", "--picture", "c.png", "--metric", "m.npz"]) == 0
    assert {p.name for p in tmp_path.iterdir()} == {"net.json", "p.html", "c.png", "m.npz"}
    assert main(["glue", "net.json", "--report", "r.json", "--metric", "r.json"]) == 2
    assert "--report and --metric are the same file r.json" in capsys.readouterr().err


def test_both_sides_of_a_triangle(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    net = {
        "polygons": [[[0, 0], [4, 0], [2, 3]], [[0, 0], [2, -3], [4, 0]]],
        "sides": [[[0, 0], [1, 2]], [[0, 1], [1, 1]], [[0, 2], [1, 0]]],
    }
    (tmp_path / "net.json").write_text(json.dumps(net))
    assert main(["glue", "net.json", "--html", "p.html", "--picture", "c.png", "--animate", "f.gif"]) == 0
    assert {p.name for p in tmp_path.iterdir()} == {"net.json", "p.html", "c.png", "f.gif"}
    assert "3 vertices, 2 faces" in (tmp_path / "p.html").read_text()
