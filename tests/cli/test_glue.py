"""``isoembed glue`` and ``isoembed nets``: from what a user types to the solid."""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import Embedding, GluedMetric, NotEmbedded
from isoembed.cli import main
from isoembed.gluing import folding
from isoembed.gluing.classics import CLASSICS
from isoembed.io import read_metric
from isoembed.io.net import read_net
from isoembed.metric import curvature
from isoembed.metric.curvature import deficits
from places import ROOT
from strict_json import strict

SQUARE = {"rectangle": [1, 1]}
CUBE = {
    "polygons": [SQUARE] * 6,
    "sides": [
        *([[0, k], [1 + k, 0]] for k in range(4)),
        *([[1 + k, 1], [1 + (k - 1) % 4, 3]] for k in range(4)),
        *([[1 + k, 2], [5, 3 - k]] for k in range(4)),
    ],
}


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Call the command in an empty folder; return its status, its output and its complaint."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        before = set(os.listdir())
        status = main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        if status == 2:
            assert set(os.listdir()) == before
            assert err.startswith("isoembed: error: ")
            assert err.count("\n") == 1
        return status, out, err

    return call


def typed(document):
    """Put a document into net.json."""
    Path("net.json").write_text(document if isinstance(document, str) else json.dumps(document))
    return "net.json"


# glue


def test_glue_writes_the_solid_and_its_report(run):
    assert run("glue", typed(CUBE), "-o", "cube.npz", "--report", "report.json")[0] == 0
    with np.load("cube.npz") as archive:
        vertices = archive["vertices"]
    assert vertices.shape == (8, 3)
    distances = np.linalg.norm(vertices[:, None] - vertices, axis=2).round(10)
    assert Counter(distances.ravel().tolist()) == Counter(
        {0.0: 8, 1.0: 24, round(2**0.5, 10): 24, round(3**0.5, 10): 8}
    )
    report = json.loads(Path("report.json").read_text())
    assert report["method"] == "alexandrov"
    assert report["volume"] == pytest.approx(1, rel=1e-10)


def test_glue_says_what_it_found(run):
    status, out, err = run("glue", typed(CUBE))
    assert (status, err) == (0, "")
    assert out.startswith("cube: 8 vertices, 12 edges, 6 faces\n")
    for words in ("converged", "area        6", "volume      1"):
        assert words in out
    assert run("glue", "net.json", "--quiet") == (0, "", "")


@pytest.mark.parametrize(
    ("document", "solid", "volume"),
    [
        ({"zip": {"polygon": SQUARE, "at": 0.5}}, "doubly covered quadrilateral", 0),
        ({"zip": {"polygon": [[0, 0], [2, 0], [2, 1], [0, 1]], "at": 1}}, "doubly covered quadrilateral", 0),
        ({"zip": {"polygon": {"triangle": [3, 4, 5]}, "at": 0.7}}, "hedron", None),
        ({"pita": {"outline": {"regular": [4, 2]}}}, "doubly covered triangle", 0),
        ({"pita": {"outline": {"circle": 1}, "at": 0.3, "n": 16}}, "doubly covered 9-gon", 0),
        ({"dform": {"outlines": [SQUARE, SQUARE], "offset": 0.125}}, "-hedron", None),
        ({"dform": {"outlines": [{"ellipse": [2, 1]}, {"stadium": [2, 1]}], "n": 16}}, "", None),
        (
            {"polygons": [{"triangle": [4, 5, 6]}], "sides": [[[0, k], [0, k]] for k in range(3)]},
            "tetrahedron: 4 vertices, 6 edges, 4 faces",
            (27 * 45 * 5 / 72) ** 0.5 / 8,
        ),
    ],
)
def test_every_form_of_a_net(run, document, solid, volume):
    status, out, err = run("glue", typed(document), "--report", "report.json")
    assert (status, err) == (0, "")
    assert solid in out.splitlines()[0]
    if volume is not None:
        assert json.loads(Path("report.json").read_text())["volume"] == pytest.approx(volume, abs=1e-9)


CURVED = {
    "coordinates": {
        "polygons": [[[0, 0], [0.5, 0], [0, 0.6]]] * 2,
        "corners": ["abc", "abc"],
        "curvature": -1,
        "model": "projective",
    },
    "names": {
        "polygons": [{"triangle": [1, 1, 1]}, {"regular": 3}, {"regular": [3, 1]}, {"triangle": [1, 1, 1]}],
        "corners": ["abc", "abd", "acd", "bcd"],
        "curvature": 0.5,
        "model": "conformal",
    },
    "regular": {"regular": ["abc", "abd", "acd", "bcd"], "curvature": -2.5},
    "zip": {"zip": {"polygon": {"regular": [5, 0.4]}, "at": 0.5}, "curvature": 1.5},
}


@pytest.mark.parametrize("document", CURVED.values(), ids=CURVED.keys())
def test_nets_of_curved_surfaces(run, document):
    assert run("glue", typed(document), "--metric", "metric.npz")[0] == 0
    metric = read_metric("metric.npz")
    assert metric.curvature == document["curvature"]
    assert deficits(metric).sum() == pytest.approx(
        4 * np.pi - metric.curvature * curvature.area(metric), rel=1e-12
    )
    assert read_net("net.json").space == metric.space


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            {"curvature": "hyperbolic"},
            "net.json: the curvature of space is 'hyperbolic', not a",
        ),
        ({"model": "klein"}, "net.json: the model is 'klein', none of conformal, projective, ambient"),
        (
            {"polygons": [[[0, 0], [2, 0], [0, 1]]] * 2},
            "polygon 0: point 1 is 2 from the center of the",
        ),
        ({"polygons": [{"rectangle": [1, 1]}] * 2}, "polygon 0 is rectangle, not one of triangle, regular"),
        ({"model": {}}, "net.json: the model is {}, none of"),
    ],
)
def test_nets_that_no_curved_surface_has(run, change, sentence):
    status, _, err = run("glue", typed({**CURVED["coordinates"], **change}), "--metric", "metric.npz")
    assert status == 2 and sentence in err


def test_the_nets_of_the_documentation_are_nets(run):
    page = (ROOT / "docs" / "net-files.md").read_text(encoding="utf-8")
    texts = " ".join(re.findall(r"```json\n(.*?)```", page, re.DOTALL)).strip()
    counts = []
    while texts:
        document, end = json.JSONDecoder().raw_decode(texts)
        texts = texts[end:].strip()
        assert run("glue", typed(document), "--metric", "metric.npz")[0] == 0
        counts.append(read_net("net.json").n_vertices)
    assert counts == [4, 4, 6, 33, 64, 4, 8]


def test_glue_reads_standard_input(run, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(json.dumps(CUBE).encode())))
    assert run("glue", "-", "-o", "cube.obj")[0] == 0
    assert Path("cube.obj").exists()
    monkeypatch.setattr(sys, "stdin", None)
    assert run("glue", "-")[0] == 2


def test_glue_writes_the_metric_alone(run, monkeypatch):
    monkeypatch.setattr(isoembed, "embed", lambda *_, **__: pytest.fail("it computed"), raising=False)
    cross = {"polygons": [{"regular": 6}], "sides": [[[0, k], [0, 5 - k]] for k in range(3)]}
    status, out, err = run("glue", typed(cross), "--metric", "metric.json")
    assert (status, err) == (0, "")
    said, files = out.splitlines()
    assert said == "Net(4 vertices, 6 edges, 4 faces, mean edge length 1.36603)"
    assert files.startswith("metric.json written, ")
    metric = read_metric("metric.json")
    assert np.sort(deficits(metric))[-4:] == pytest.approx(np.pi * np.array([2, 2, 4, 4]) / 3, rel=1e-12)
    assert run("glue", "net.json", "--metric", "metric.npz", "--quiet") == (0, "", "")


def test_glue_writes_the_metric_beside_the_solid(run):
    assert run("glue", typed(CUBE), "--metric", "metric.npz", "-o", "cube.ply")[0] == 0
    assert read_metric("metric.npz").triangulation.n_vertices == 8
    assert Path("cube.ply").exists()


def test_glue_prints_the_report_as_json_and_solves_for_it(run):
    status, out, err = run("glue", typed(CUBE), "--json", "--metric", "m.json")
    assert (status, err) == (0, "")
    report = strict(out)
    assert report["volume"] == pytest.approx(1)
    assert report["polyhedron"] == {"vertices": 8, "faces": 6, "flat_vertices": 0}
    assert os.path.exists("m.json")


def test_glue_that_fails_says_so(run, monkeypatch):
    vertices, faces = zoo.icosphere(0)
    metric = isoembed.PolyhedralMetric.from_mesh(vertices, faces)

    def attempt(net, method, **_):
        assert isinstance(net, GluedMetric)
        best = Embedding(metric, 2 * vertices, method="alexandrov", tolerance=1e-10)
        raise NotEmbedded("the path ended", best)

    monkeypatch.setattr("isoembed.gluing.solid.solve", attempt)
    status, out, err = run("glue", typed(CUBE), "-o", "cube.obj", "--report", "report.json")
    assert (status, err) == (3, "isoembed: error: the path ended\n")
    assert re.fullmatch(r"not converged: report.json written, \S+ s; --keep writes the best attempt\n", out)
    assert sorted(os.listdir()) == ["net.json", "report.json"]
    assert json.loads(Path("report.json").read_text())["message"] == "the path ended"
    assert run("glue", "net.json", "-o", "cube.obj", "--keep")[0] == 3
    assert Path("cube.obj").exists()
    assert "not converged" in run("glue", "net.json")[1]


def test_a_net_with_too_much_angle_is_refused(run):
    # Two sides of a reflex corner glued together leave more than a full angle at another.
    arrow = [[0, 0], [2, -1], [1, 0], [2, 1]]
    document = {"dform": {"outlines": [arrow, [[x, -y] for x, y in arrow]]}}
    status, _, err = run("glue", typed(document))
    assert status == 2
    assert "540 degrees, meets at [1, 0] (vertex 2): are the right sides glued?" in err


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ("{", "net.json is not JSON"),
        ("[]", "net.json holds a JSON list"),
        (
            {},
            "net.json holds nothing: a net is polygons with sides or corners, or one of regular, zip",
        ),
        ({"sides": []}, "net.json holds sides: a net is polygons with sides or corners, or one of"),
        ({"polygons": [], "zip": {}}, "net.json holds polygons and zip: a net is"),
        ({"polygons": []}, "net.json lacks 'sides'"),
        ({"polygons": [], "sides": [], "side": 1}, "net.json has 'side', which is none of polygons, sides"),
        ({"polygons": 3, "sides": []}, "the polygons of net.json are not a list"),
        ({"polygons": [SQUARE], "sides": {}}, "the sides of net.json are not a list"),
        ({"polygons": [SQUARE], "sides": [[[0, 0], [0, 2]]]}, "side 1 of polygon 0 is glued to nothing"),
        ({"polygons": [SQUARE], "sides": [[[0, 0], "a"]]}, "sides[0] glues 'a', which is neither"),
        ({"polygons": ["a"], "sides": []}, "polygon 0 is not a list of corners [x, y]"),
        ({"polygons": [[[0, 0], [1, 0], [0, None]]], "sides": []}, "polygon 0 is not a list of corners"),
        (
            {"polygons": [{"circle": 1}], "sides": []},
            "polygon 0 is circle, not one of rectangle, triangle, r",
        ),
        ({"polygons": [{}], "sides": []}, "polygon 0 is nothing, not one of rectangle"),
        ({"polygons": [{"rectangle": 1}], "sides": []}, "polygon 0 is a rectangle of 1 numbers, not 2"),
        ({"polygons": [{"regular": [1, 2, 3]}], "sides": []}, "is a regular of 3 numbers, not 1 or 2"),
        ({"polygons": [{"regular": 2}], "sides": []}, "n is 2, not a whole number of sides"),
        ({"polygons": [{"triangle": [1, 1, "a"]}], "sides": []}, "triangle has c = 'a', not a positive"),
        (
            {"polygons": [{"regular": 3}] * 4, "corners": ["abe", "bce", "cde", "dae"], "any_surface": True},
            "'isoembed glue net.json --metric metric.npz' and then 'isoembed embed metric.npz",
        ),
        ({"zip": 3}, "zip of net.json is not an object with polygon, at"),
        ({"zip": {"polygon": SQUARE}}, "zip of net.json lacks 'at'"),
        ({"zip": {"polygon": SQUARE, "at": "a"}}, "at is 'a', not a position on the boundary from 0 to 4"),
        ({"zip": {"polygon": SQUARE, "at": 1}, "n": 3}, "net.json has 'n', which is none of zip"),
        (
            {"pita": {"outline": SQUARE, "art": 1}},
            "pita of net.json has 'art', which is none of outline, at, n",
        ),
        (
            {"pita": {"outline": {"square": 1}}},
            "the outline is square, not one of rectangle, triangle, regular, c",
        ),
        ({"pita": {"outline": {"ellipse": [1, 1e400]}}}, "ellipse has b = inf, not a positive finite number"),
        ({"pita": {"outline": {"circle": 1}, "n": 2}}, "n is 2, not a whole number of sides"),
        ({"dform": {"outlines": [SQUARE]}}, "the outlines of net.json are 1, not 2"),
        ({"dform": {"outlines": SQUARE}}, "the outlines of net.json are not a list"),
        ({"dform": {"outlines": [SQUARE, SQUARE], "offset": 1}}, "offset is 1, not a fraction of the"),
    ],
)
def test_every_mistake_in_a_net_is_one_line(run, document, sentence):
    status, _, err = run("glue", typed(document).replace("Infinity", "1e400"))
    assert status == 2
    assert sentence in err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["net.txt"], "net.txt has the ending '.txt', not one of .json"),
        (["missing.json"], "there is no file missing.json"),
        (["net.json", "-o", "solid.xyz"], "solid.xyz has the ending '.xyz'"),
        (["net.json", "--metric", "metric.obj"], "metric.obj has the ending '.obj', not one of .npz .json"),
        (["net.json", "--metric", "a.npz", "-o", "a.npz"], "--output and --metric are the same file a.npz"),
        (["net.json", "--metric", "a.json", "--report", "a.json"], "--report and --metric are the same file"),
        (["net.json", "--keep"], "--keep needs an --output"),
        ([], "the following arguments are required: FILE "),
    ],
)
def test_every_mistake_on_the_command_line_is_one_line(run, arguments, sentence):
    typed(CUBE)
    status, _, err = run("glue", *arguments)
    assert status == 2
    assert sentence in err


# nets


def rows(out):
    """The table as a list of {heading: entry}."""
    header, *lines = out.split("\n\n")[0].splitlines()
    starts = {name: header.index(name) for name in ("net", "solid")}
    table = []
    for line in lines:
        net, rest = line[starts["net"] : starts["solid"]].strip(), line[starts["solid"] :]
        solid, *numbers = rest.rsplit(maxsplit=5)
        table.append((net, solid.strip(), *map(float, numbers)))
    return table


def test_nets_are_listed(run):
    status, out, err = run("nets")
    assert (status, err) == (0, "")
    assert [line.split()[0] for line in out.splitlines()] == list(CLASSICS)


def test_the_latin_cross_folds_to_five_solids(run):
    status, out, err = run("nets", "latin-cross")
    assert (status, err) == (0, "")
    table = rows(out)
    assert len(table) == 17
    assert out.endswith("\n17 nets, 5 solids\n")
    found = {(solid.split(": ")[1], *counts, round(volume, 6)) for _, solid, *counts, _, volume in table}
    assert found == {
        ("cube", 8, 12, 6, 1.0),
        ("tetrahedron", 4, 6, 4, round(3**-0.5, 6)),
        ("pentahedron", 5, 8, 5, round(2 / 3, 6)),
        ("octahedron", 6, 12, 8, 0.922367),
        ("doubly covered quadrilateral", 4, 4, 2, 0.0),
    }
    assert {area for *_, area, _ in table} == {6.0}


def test_nets_are_solved_in_json(run):
    status, out, err = run("nets", "platonic", "--json", "--quiet")
    assert (status, err) == (0, "")
    report = strict(out)
    assert report["failures"] == []
    names = [solid["solid"] for solid in report["solids"]]
    assert len(set(names)) == 5
    cube = report["solids"][names.index("cube")]
    assert (cube["vertices"], cube["edges"], cube["faces"]) == (8, 12, 6)
    assert (cube["area"], cube["volume"]) == pytest.approx((6, 1))


def test_tetramonohedra_have_the_volume_of_their_faces(run):
    # Lattice reduction: the faces of the tetrahedron are the acute triangle with the same lattice.
    status, out, _ = run("nets", "tetramonohedra")
    assert status == 0
    for net, solid, *_, area, volume in rows(out):
        words = net.replace(",", "").split()
        if words[0] == "triangle":
            a, b, c = (float(word) / 2 for word in words[1:4])
            u = np.array([c, 0.0])
            v = np.array([(b * b + c * c - a * a) / (2 * c), 0.0])
            v[1] = (b * b - v[0] ** 2) ** 0.5
        else:
            width, height, twist = float(words[1]), float(words[3]), float(words[5])
            u, v = np.array([width / 2, 0.0]), np.array([twist, height])
        while True:
            u, v = sorted((u, v), key=np.linalg.norm)
            step = round(u @ v / (u @ u))
            if step == 0:
                break
            v = v - step * u
        w = u - v if u @ v > 0 else u + v
        a2, b2, c2 = (side @ side for side in (u, v, w))
        expected = (max((a2 + b2 - c2) * (a2 - b2 + c2) * (-a2 + b2 + c2), 0) / 72) ** 0.5
        assert volume == pytest.approx(expected, abs=1e-7), net
        assert area == pytest.approx(2 * abs(u[0] * v[1] - u[1] * v[0]), rel=1e-8)
        assert ("tetrahedron" if expected > 1e-6 else "doubly covered quadrilateral") in solid


def test_platonic_solids_have_their_volumes(run):
    status, out, _ = run("nets", "platonic")
    assert status == 0
    found = {solid.split(": ")[1]: volume for _, solid, *_, volume in rows(out)}
    assert found == pytest.approx(
        {
            "regular tetrahedron": 2**0.5 / 12,
            "cube": 1,
            "regular octahedron": 2**0.5 / 3,
            "regular dodecahedron": (15 + 7 * 5**0.5) / 4,
            "regular icosahedron": 5 * (3 + 5**0.5) / 12,
        },
        rel=1e-8,
    )


@pytest.mark.parametrize("name", ["pitas", "dforms"])
def test_curved_forms_are_solved(run, name):
    status, out, err = run("nets", name)
    assert (status, err) == (0, "")
    assert len(rows(out)) == len(CLASSICS[name].make())


def test_nets_are_written_one_by_one(run):
    assert run("nets", "platonic", "-o", "solid.obj", "--quiet") == (0, "", "")
    assert sorted(os.listdir()) == [f"solid-{k}.obj" for k in range(1, 6)]


def test_nets_that_fail_say_so(run, monkeypatch):
    vertices, faces = zoo.icosphere(0)
    metric = isoembed.PolyhedralMetric.from_mesh(vertices, faces)
    solve = folding.solve

    def attempt(net, method):
        if net.n_vertices == 20:
            raise NotEmbedded("lost", Embedding(metric, vertices, method="alexandrov", tolerance=1e-10))
        return solve(net, method)

    monkeypatch.setattr(folding, "solve", attempt)
    status, out, err = run("nets", "platonic", "-o", "solid.npz")
    assert status == 3
    assert err == "isoembed: error: net 4, 12 pentagons: lost\n"
    assert len(rows(out)) == 4
    assert sorted(os.listdir()) == [f"solid-{k}.npz" for k in (1, 2, 3, 5)]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["greek-cross"], "invalid choice: 'greek-cross'"),
        (["platonic", "-o", "solid.xyz"], "solid-1.xyz has the ending '.xyz'"),
        (["platonic", "-o", "nowhere/solid.obj"], "there is no folder"),
        (["--json"], "--json needs the NAME of a net: latin-cross"),
    ],
)
def test_every_mistake_about_nets_is_one_line(run, arguments, sentence):
    status, _, err = run("nets", *arguments)
    assert status == 2
    assert sentence in err


def test_the_report_has_the_correction(run):
    triangle = [[0, 0], [1, 0], [0.5, 0.866025]]
    document = {"polygons": [triangle] * 4, "corners": ["abc", "adb", "bdc", "adc"]}
    status, out, err = run("glue", typed(document), "--json")
    assert status == 0
    assert "sides differ by up to 3.5e-07" in err
    correction = strict(out)["correction"]
    assert 0 < correction["rms"] < correction["largest"] < correction["difference"] < 4e-7
    assert run("glue", "net.json", "--report", "report.json")[0] == 0
    assert strict(Path("report.json").read_text())["correction"] == correction
    assert "correction" not in strict(run("glue", typed(CUBE), "--json")[1])
