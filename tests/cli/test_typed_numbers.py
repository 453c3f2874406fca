"""Files with rounded, typed and measured numbers of others: what the command makes of each."""

import importlib.util
import json

import numpy as np
import pytest

import isoembed
from isoembed import PolyhedralMetric
from isoembed.cli import main
from isoembed.io import read_surface
from places import SHARED

NUMBERS = SHARED / "trials" / "numbers"

pytestmark = pytest.mark.shared

TETRAHEDRON = 2**0.5 / 12
STEFFEN_RIGID, STEFFEN_FLEXIBLE = 616.515180729, 17 * 11 * 41.5**0.5 / 6
LENS = 0.0209438132  # closed form of the bipyramid


def ran(*arguments):
    return main([str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("name", "options", "volume", "error"),
    [
        ("01_cube_6_decimals.obj", (), 1.0, 1e-6),
        ("04_steffen.json", (), STEFFEN_RIGID, 1e-10),
        ("04_steffen.json", ("--which", NUMBERS / "04_steffen_flexible_pose.json"), STEFFEN_FLEXIBLE, 1e-10),
        ("05_lens_1000gon.obj", (), LENS, 1e-8),
        ("05_lens_1000gon.obj", ("--method", "alexandrov"), LENS, 1e-8),
        ("06_zonohedron_12_decimals.obj", ("--method", "alexandrov"), 17.204774005890, 1e-10),
        ("09_L_prism.obj", (), 9.0, 1e-10),
    ],
)
def test_embed(name, options, volume, error, tmp_path):
    report = tmp_path / "r.json"
    assert (
        ran("embed", NUMBERS / name, *options, "-o", tmp_path / "s.ply", "--report", report, "--quiet") == 0
    )
    said = json.loads(report.read_text())
    assert said["status"] == "converged"
    assert said["volume"] == pytest.approx(volume, rel=error)
    if said["input"]["vertices"] < 1000:
        assert said["certificate"]["certified"] == (volume != STEFFEN_FLEXIBLE)


@pytest.mark.parametrize("name", ["uppercase", "cr_line_ends", "bom", "binary_with_newline_at_end"])
def test_stl_of_other_programs(name, tmp_path):
    assert ran("embed", NUMBERS / f"07_{name}.stl", "-o", tmp_path / "s.ply", "--quiet") == 0
    assert read_surface(tmp_path / "s.ply").volume == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("ending", [".obj", ".ply", ".off", ".stl", ".json", ".npz", ".vtk", ".vtu", ".fold"])
@pytest.mark.parametrize(
    ("name", "volume", "folds"),
    [
        ("01_cube_6_decimals.obj", 1.0, 5),
        ("06_zonohedron_12_decimals.obj", 17.204774, 19),
        ("09_L_prism.obj", 9, 7),
    ],
)
def test_net_and_back(name, volume, folds, ending, tmp_path):
    surface, net = tmp_path / f"s{ending}", tmp_path / "n.json"
    assert ran("embed", NUMBERS / name, "-o", surface, "--quiet") == 0
    assert ran("unfold", surface, "-o", net, "--quiet") == 0
    assert sum(map(len, json.loads(net.read_text())["folds"])) == folds
    assert ran("glue", net, "-o", tmp_path / "b.ply", "--quiet") == 0
    assert read_surface(tmp_path / "b.ply").volume == pytest.approx(volume, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "volume", "error"),
    [("02_tetrahedron_net_typed.json", TETRAHEDRON, 1e-6), ("09_L_prism_net.fold", 9.0, 1e-10)],
)
def test_glue(name, volume, error, tmp_path):
    assert ran("glue", NUMBERS / name, "-o", tmp_path / "s.ply", "--quiet") == 0
    assert read_surface(tmp_path / "s.ply").volume == pytest.approx(volume, rel=error)


@pytest.mark.parametrize(
    ("command", "name", "sentence"),
    [
        (
            "glue",
            "09_L_prism_net_from_unfold.json",
            'the net lacks its fold angles: "folds" (.json), for each',
        ),
        ("embed", "11_collinear_triangle.obj", "vertex 8 is on the side from vertex 0 to vertex 1"),
        ("embed", "13_damaged_points.vtk", "among the points"),
    ],
)
def test_refusals(command, name, sentence, tmp_path, capsys):
    assert ran(command, NUMBERS / name, "-o", tmp_path / "s.ply") == 2
    assert sentence in capsys.readouterr().err


def test_the_remedy_of_a_vertex_on_a_side(tmp_path):
    options = ("--merge", "-o", tmp_path / "s.ply", "--quiet")
    assert ran("embed", NUMBERS / "11_collinear_triangle.obj", *options) == 0
    assert read_surface(tmp_path / "s.ply").volume == pytest.approx(1.0, rel=1e-10)


def test_an_edge_among_the_faces_and_faces_of_any_orientation(tmp_path, capsys):
    assert ran("embed", NUMBERS / "08_explicit_edge.off", "-o", tmp_path / "s.ply", "--quiet") == 0
    assert read_surface(tmp_path / "s.ply").volume == pytest.approx(1.0, rel=1e-10)
    name = "10_tetrahedron_any_orientation.json"
    assert ran("embed", NUMBERS / name, "-o", tmp_path / "s.ply") == 0
    assert "2 of 4 faces are reversed" in capsys.readouterr().err


def farthest(found, true):
    """The largest distance of a vertex from its true place after the best rigid motion, mirrored or not."""
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    return float(np.linalg.norm(a @ (u @ v) - b, axis=1).max())


def test_a_rock_in_whole_millimeters():
    told = json.loads((NUMBERS / "03_rock_80_vertices_whole_mm.json").read_text())
    true = np.array(json.loads((NUMBERS / "03_rock_true.json").read_text())["vertices"])
    metric = PolyhedralMetric(told["faces"], told["lengths"], told["edges"])
    for best_fit in (False, True):
        found = isoembed.embed(metric, method=isoembed.Aim(best_fit=best_fit))
        assert farthest(found.vertices, true) < 3
        [exact] = found.others
        assert exact.residual < 1e-10 and farthest(exact.vertices, true) > 30


@pytest.mark.filterwarnings("ignore:embedding.concave_edges:DeprecationWarning")  # an old script
def test_a_needle_that_both_methods_find(capsys):
    spec = importlib.util.spec_from_file_location("bipyramid", NUMBERS / "14_bipyramid_refused.py")
    spec.loader.exec_module(importlib.util.module_from_spec(spec))
    aim, alexandrov = capsys.readouterr().out.splitlines()
    for line in (aim, alexandrov):
        _, residual, volume, concave = line.split()
        assert float(residual) < 1e-14 and float(volume) == pytest.approx(123.349730318) and concave == "0"


def test_twins_of_schoenhardt_polyhedra():
    told = (NUMBERS / "12_schoenhardt_others.py").read_text()
    script = {}
    exec(told[: told.index("for deg in")], script)  # its definitions
    for degrees in (26, 28, 29, 29.5, 30.5, 31, 32, 34):
        vertices, faces = script["sch"](degrees)
        found = isoembed.embed(PolyhedralMetric.from_mesh(vertices, faces))
        within = isoembed.realizations(found, distance=0.05).surfaces
        assert len(found.others) == len(within) - 1 == 1
