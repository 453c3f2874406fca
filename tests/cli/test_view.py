"""``isoembed view``: pages and pictures of surfaces in files."""

import base64
import json
import re
import webbrowser
from pathlib import Path
from urllib.parse import urlparse

import numpy as np
import pytest
from PIL import Image

import zoo
from isoembed.cli import main
from isoembed.errors import MeshNote
from isoembed.io import write_surface
from isoembed.io.registry import FORMATS
from isoembed.io.surface import read_with_curvatures
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot.coloring import from_file, quantities
from isoembed.surface.measures import area


def ellipsoid():
    vertices, faces = zoo.icosphere(1)
    return vertices * [3.0, 2.0, 1.0], faces


def report(page):
    coded = re.search(r'download="report.json" href="data:application/json;base64,([^"]*)"', page.read_text())
    return json.loads(base64.b64decode(coded[1]))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(name, **tables):
    FORMATS[Path(name).suffix].write(Path(name), tables)


@pytest.mark.parametrize("kind", ["npz", "json", "ply", "vtk", "vtu", "vtp"])
def test_curvatures_in_the_file_are_the_colors(kind, folder):
    vertices, faces = ellipsoid()
    H, K = np.random.default_rng(1).random((2, len(vertices)))
    write(f"a.{kind}", vertices=vertices, faces=faces, mean_curvature=H, gaussian_curvature=K)
    surface, given = read_with_curvatures(f"a.{kind}")
    np.testing.assert_array_equal(given["mean_curvature"], H)
    found = {each.name: each for each in quantities(surface, from_file(given))}
    np.testing.assert_array_equal(found["Gaussian curvature"].values, K)
    assert "as in the file" in found["mean curvature"].label and "residual" in found


def test_curvatures_of_merged_vertices_are_left_aside(folder):
    vertices, faces = ellipsoid()
    twice = np.concatenate([vertices, vertices[:1]])
    faces = np.concatenate([np.where(faces[:1] == 0, len(vertices), faces[:1]), faces[1:]])
    write("a.ply", vertices=twice, faces=faces, mean_curvature=np.ones(len(twice)))
    with pytest.warns(MeshNote):
        surface, given = read_with_curvatures("a.ply", merge=0.0)
    assert surface.triangulation.n_vertices == len(vertices) and not given


def test_curvatures_in_a_text_ply(folder):
    rows = [(0, 0, 0, 1), (1, 0, 0, 2), (0, 1, 0, 3), (0, 0, 1, 4)]
    head = ["ply", "format ascii 1.0", "element vertex 4", "property float x", "property float y"]
    head += ["property float z", "property float mean_curvature", "element face 4"]
    head += ["property list uchar int vertex_indices", "end_header"]
    faces = ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 2 0 3"]
    Path("a.ply").write_text("\n".join([*head, *(" ".join(map(str, row)) for row in rows), *faces, ""]))
    assert read_with_curvatures("a.ply")[1]["mean_curvature"].tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize("kind", ["npz", "json", "ply", "obj", "stl", "off", "vtk", "vtu"])
def test_every_format_becomes_a_page(kind, folder):
    vertices, faces = ellipsoid()
    write(f"a.{kind}", vertices=vertices, faces=faces)
    assert main(["view", f"a.{kind}", "-o", "a.html"]) == 0
    found = report(folder / "a.html")
    assert found["method"] == "given"
    assert found["status"] == "converged"
    assert found["message"] == "the lengths are computed from the vertices in the file"
    assert found["area"] == pytest.approx(area(faces, vertices))
    assert f"<h1>a.{kind}</h1>" in (folder / "a.html").read_text()


def test_lengths_in_the_file_are_what_residuals_are_against(folder):
    vertices, faces = ellipsoid()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    lengths = metric.lengths.copy()
    lengths[7] += 0.01 * metric.mean_length
    tables = {"faces": faces, "edges": metric.edges, "lengths": lengths, "vertices": vertices}
    write("a.npz", **tables)
    assert main(["view", "a.npz", "-o", "a.html"]) == 0
    found = report(folder / "a.html")
    assert found["status"] == "not converged"
    assert found["residual"]["max"] == pytest.approx(0.01, rel=1e-3)
    assert "at edge 7" in found["message"]


def test_faces_that_look_inward_are_turned_not_mirrored(folder):
    vertices, faces = ellipsoid()
    vertices = vertices * np.where(vertices > 0, [1.0, 1.3, 1.7], 1.0)  # no mirror image of itself
    for name, oriented in (("out", faces), ("in", faces[:, ::-1])):
        write(f"{name}.ply", vertices=vertices, faces=oriented)
        assert main(["view", f"{name}.ply", "-o", f"{name}.html"]) == 0
    np.testing.assert_array_equal(positions(folder / "in.html"), positions(folder / "out.html"))


def positions(page):
    """Of the vertices, as the page has them."""
    text = page.read_text()
    data, arrays = (re.search(rf'id="{name}">([^<]*)', text)[1] for name in ("data", "arrays"))
    entry = json.loads(data)["frames"][-1]["positions"]
    return np.frombuffer(base64.b64decode(arrays), "<f4", entry["count"], entry["at"])


@pytest.mark.parametrize(("kind", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_pictures(kind, magic, folder):
    pytest.importorskip("matplotlib")
    vertices, faces = zoo.icosahedron()
    write("a.off", vertices=vertices, faces=faces)
    assert main(["view", "a.off", "-o", f"a.{kind}", "--color", "Gaussian curvature"]) == 0
    assert (folder / f"a.{kind}").read_bytes().startswith(magic)


def test_what_embed_wrote_can_be_seen(folder):
    from isoembed import embed

    vertices, faces = zoo.icosahedron()
    write_surface("a.npz", embed(PolyhedralMetric.from_mesh(vertices, faces)))
    assert main(["view", "a.npz", "-o", "a.html"]) == 0


@pytest.mark.parametrize("opened", [True, False])
def test_without_an_output_the_browser_opens(opened, folder, monkeypatch, capsys):
    asked = []
    monkeypatch.setattr(webbrowser, "open", lambda uri: asked.append(uri) or opened)
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    write("cube.obj", **dict(zip(("vertices", "faces"), zoo.cube(), strict=True)))
    assert main(["view", "cube.obj"]) == 0
    (page,) = folder.glob("isoembed-*/cube.html")
    assert [urlparse(uri).path for uri in asked] == [str(page)]
    said = capsys.readouterr().out.strip()
    assert said.startswith(str(page))
    assert ("no browser could be opened" in said) != opened


def test_a_series_is_a_page_with_a_slider_or_a_film(folder):
    vertices, faces = zoo.cube()
    for k in (1, 2, 3):
        write(f"{k}.ply", vertices=vertices * [1.0, 1.0, k], faces=faces)
    assert main(["view", "1.ply", "2.ply", "3.ply", "-o", "a.html"]) == 0
    page = (folder / "a.html").read_text()
    assert '"stage": "1"' in page and '"stage": "2"' in page and "<h1>3.ply</h1>" in page
    assert main(["view", "1.ply", "2.ply", "-o", "a.gif"]) == 0
    with Image.open("a.gif") as film:
        assert film.n_frames == 5 + 30  # half a second from one to the other, and a turn


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["metric.npz"], "metric.npz is a metric without vertices: embed it first, with 'isoembed embed"),
        (["nothing.ply"], "there is no file nothing.ply"),
        (
            ["cube.ply", "-o", "a.txt"],
            "a.txt has the ending '.txt', not one of .html .png .svg .pdf .gif .mp4",
        ),
        (["cube.ply", "cube.ply", "-o", "a.png"], "a picture shows a single surface"),
        (["cube.ply", "torus.off", "-o", "a.gif"], "torus.off has 20 vertices, cube.ply has 8"),
        (["cube.ply", "-o", "a.gif", "--color", "residual"], "--color is for pictures"),
        (["cube.ply", "-o", "no/a.html"], "there is no folder"),
        (["cube.ply", "--color", "residual"], "--color is for pictures"),
        (["cube.ply", "-o", "a.html", "--color", "residual"], "--color is for pictures"),
        (["cube.ply", "-o", "a.png", "--color", "taste"], "invalid choice: 'taste'"),
        (["short.npz"], "a face refers to vertex 7, but there are only 7 vertices"),
        (["plane.npz"], "plane.npz holds vertices of shape (8, 2), not (V, 3)"),
    ],
)
def test_what_is_refused(arguments, words, folder, capsys):
    vertices, faces = zoo.cube()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    write("cube.ply", vertices=vertices, faces=faces)
    lengths = {"faces": faces, "edges": metric.edges, "lengths": metric.lengths}
    write("metric.npz", **lengths)
    write("short.npz", **lengths, vertices=vertices[:7])
    write("plane.npz", **lengths, vertices=np.column_stack([vertices @ [1, 2, 4], vertices @ [4, 1, 2]]))
    write("torus.off", vertices=np.random.default_rng(0).normal(size=(20, 3)), faces=zoo.torus())
    assert main(["view", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not list(folder.glob("a.*"))
