"""Nets in FOLD: what is unfolded and written is glued again to the same solid."""

import json
import re

import numpy as np
import pytest

import isoembed
import zoo
from damage import refusals
from isoembed.gluing.classics import CLASSICS
from isoembed.io import FileError
from isoembed.io.net import read_net, write_net

PLATONIC = dict(CLASSICS["platonic"].make())


@pytest.fixture
def path(tmp_path):
    return tmp_path / "net.fold"


@pytest.mark.parametrize("name", PLATONIC)
def test_platonic_solids_come_back(name, path):
    solid = isoembed.embed(PLATONIC[name], method="alexandrov")
    write_net(path, isoembed.unfold(solid))
    net = json.loads(path.read_text())
    v, e, f = (len(net[key]) for key in ("vertices_coords", "edges_vertices", "faces_vertices"))
    assert f == int(name.split()[0]) and v - e + f == 1  # a disc
    # A tree of folds, and a boundary of twice the edges that are cut.
    edges = len(solid.metric.edges) - (~solid.surface.flat_faces.edges).sum()
    letters = net["edges_assignment"]
    assert letters.count("M") == f - 1 and letters.count("B") == 2 * (edges - f + 1)
    bend = isoembed.surface.curvature.dihedral_angles(solid.triangulation, solid.vertices).max()
    folded = np.array(letters) == "M"
    assert np.array(net["edges_foldAngle"])[folded] == pytest.approx(-np.degrees(bend))
    again = isoembed.embed(read_net(str(path)), method="alexandrov")
    assert again.volume == pytest.approx(solid.volume, rel=1e-9)


@pytest.mark.parametrize("unit", [1e-300, 1e300])
def test_any_unit_comes_back(unit, path):
    points, faces = zoo.cube()
    metric = isoembed.PolyhedralMetric.from_mesh(points * unit, faces)
    solid = isoembed.Embedding(metric, points * unit, method="given", tolerance=1e-10)
    write_net(path, isoembed.unfold(solid))
    assert read_net(str(path)).n_vertices == 8


def test_a_hull_of_many_vertices_comes_back(path):
    points, faces = zoo.random_hull(40, seed=2)
    metric = isoembed.PolyhedralMetric.from_mesh(points, faces)
    solid = isoembed.embed(metric, method="alexandrov")
    write_net(path, isoembed.unfold(solid))
    again = isoembed.embed(read_net(str(path)), method="alexandrov")
    assert again.volume == pytest.approx(solid.volume, rel=1e-8)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"vertices_isoembed:corner": None, "edges_foldAngle": None},
            "has no vertices_isoembed:corner: a net is a crease",
        ),
        ({"faces_vertices": []}, "has no faces_vertices"),
        ({"vertices_isoembed:corner": "abc"}, "is not a list of 14 names, one for each vertex"),
        ({"vertices_coords": [[0, 0, 0]] * 14}, "its vertices_coords are not points [x, y]"),
        ({"vertices_coords": [[0, 0], [1e999, 0]] * 7}, "vertex 1 is at [inf, 0.0], which is not finite"),
        ({"faces_vertices": [[0, 1, 2, 99]]}, "face 0 is not made of the 14 vertices"),
        ({"faces_vertices": [[0, 1, 2, 0.5]]}, "face 0 is not made of the 14 vertices"),
    ],
)
def test_what_is_no_net(path, changes, sentence):
    solid = isoembed.embed(PLATONIC["6 squares"], method="alexandrov")
    write_net(path, isoembed.unfold(solid))
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))
    with pytest.raises(FileError, match=re.escape(sentence)):
        read_net(str(path))


@pytest.mark.parametrize("name", PLATONIC)
@pytest.mark.parametrize(("decimals", "error"), [(15, 1e-9), (5, 1e-4)])
@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
def test_a_net_without_names_is_glued_where_it_folds_up(name, decimals, error, path):
    solid = isoembed.embed(PLATONIC[name], method="alexandrov")
    write_net(path, isoembed.unfold(solid))
    named = read_net(str(path))
    document = json.loads(path.read_text())
    del document["vertices_isoembed:corner"]
    document["edges_foldAngle"] = [round(angle, 4) for angle in document["edges_foldAngle"]]
    document["vertices_coords"] = np.round(document["vertices_coords"], decimals).tolist()
    path.write_text(json.dumps(document))
    net = read_net(str(path))
    assert net.n_vertices == named.n_vertices
    again = isoembed.embed(net, method="alexandrov")
    assert again.volume == pytest.approx(solid.volume, rel=error)


def test_valleys_are_folded_the_other_way(path):
    # A box whose top is pressed in: of two boxes with these faces it is the one that the angles tell.
    points = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [0, 1], [1, 1], [2, 1], [3, 1], [4, 1]]
    points += [[1, 2], [2, 2], [1, -1], [2, -1]]
    faces = [[0, 1, 6, 5], [1, 2, 7, 6], [2, 3, 8, 7], [3, 4, 9, 8], [6, 7, 11, 10], [12, 13, 2, 1]]
    edges = [[1, 6], [2, 7], [3, 8], [6, 7], [1, 2]]
    document = {"vertices_coords": points, "faces_vertices": faces, "edges_vertices": edges}
    for sign in (1, -1):  # all mountains or all valleys: the cube, or its mirror image
        path.write_text(json.dumps(document | {"edges_foldAngle": [90 * sign] * 5}))
        net = read_net(str(path))
        assert isoembed.embed(net, method="alexandrov").volume == pytest.approx(1)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"edges_foldAngle": [1.0]}, "is not a list of 19 angles, one for each edge"),
        ({"edges_foldAngle": ["a"] * 19}, "the fold angle of edge 0 is 'a', not from -180 to 180"),
        ({"edges_foldAngle": [200] * 19}, "the fold angle of edge 0 is 200, not from -180 to 180"),
        ({"edges_foldAngle": [0.0] * 19}, "is glued to nothing"),
        ({"edges_foldAngle": [None] * 19}, "has no fold angle"),
        ({"edges_foldAngle": None}, "has no vertices_isoembed:corner"),
        ({"edges_vertices": None}, "has no edges_vertices"),
        ({"edges_vertices": [[0, 1e999]] * 19}, "edge 0 does not have two ends"),
        ({"edges_vertices": [[0, 1, 2]] * 19}, "edge 0 does not have two ends"),
        ({"vertices_coords": [[0, 0]] * 14}, "side 0 of polygon 0 has no length"),
    ],
)
def test_angles_that_close_no_net(path, changes, sentence):
    write_net(path, isoembed.unfold(isoembed.embed(PLATONIC["6 squares"], method="alexandrov")))
    document = json.loads(path.read_text())
    del document["vertices_isoembed:corner"]
    path.write_text(json.dumps(document | changes))
    with pytest.raises(
        (FileError, isoembed.InvalidMetric, isoembed.InvalidParameter), match=re.escape(sentence)
    ):
        read_net(str(path))


def test_angles_that_tear_a_sheet(path):
    # Four squares around a vertex cannot be folded by 90 degrees along one crease alone.
    points = [[x, y] for y in range(3) for x in range(3)]
    faces = [[0, 1, 4, 3], [1, 2, 5, 4], [4, 5, 8, 7], [3, 4, 7, 6]]
    edges = [[1, 4], [4, 5], [4, 7], [3, 4]]
    document = {"vertices_coords": points, "faces_vertices": faces, "edges_vertices": edges}
    path.write_text(json.dumps(document | {"edges_foldAngle": [90, 0, 0, 0]}))
    with pytest.raises(
        isoembed.InvalidMetric, match=r"the fold angles tear the sheet: vertex . of face . is in two"
    ):
        read_net(str(path))
    document |= {"faces_vertices": [faces[0], faces[2]], "edges_foldAngle": [0] * 4}
    path.write_text(json.dumps(document))
    with pytest.raises(isoembed.InvalidMetric, match="face 1 has no side in common with the sheet of face 0"):
        read_net(str(path))


@pytest.mark.parametrize(
    "other",
    [
        *(None, 7, "a", {}, [], [None], [[]], [[None]], [["a"]], [[1.5, 2, 3]], [{}], True, [[0, 1, 2], []]),
        [10**400],
    ],
)
@pytest.mark.parametrize("key", ["vertices_coords", "faces_vertices", "edges_vertices", "edges_foldAngle"])
def test_tables_of_another_kind(path, key, other):
    write_net(path, isoembed.unfold(isoembed.embed(PLATONIC["6 squares"], method="alexandrov")))
    document = json.loads(path.read_text())
    del document["vertices_isoembed:corner"]
    path.write_text(json.dumps(document | {key: other}))
    with pytest.raises((FileError, isoembed.InvalidMetric, isoembed.InvalidParameter)) as refusal:
        read_net(str(path))
    assert "\n" not in str(refusal.value)


def test_damaged_files(path):
    write_net(path, isoembed.unfold(isoembed.embed(PLATONIC["4 triangles"], method="alexandrov")))
    document = json.loads(path.read_text())
    del document["vertices_isoembed:corner"]
    data = json.dumps(document).encode()
    assert refusals(path, data, read=lambda path: read_net(str(path))) > 200
