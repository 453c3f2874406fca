"""Nets in FOLD: what is unfolded and written is glued again to the same solid."""

import json
import re

import numpy as np
import pytest

import isoembed
import zoo
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
    edges = len(solid.metric.edges) - (~solid.polygon_edges).sum()
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
            {"vertices_isoembed:corner": None},
            "has no vertices_isoembed:corner: a net is a crease",
        ),
        ({"faces_vertices": []}, "has no faces_vertices"),
        ({"vertices_isoembed:corner": "abc"}, "is not a list of 14 names, one for each vertex"),
        ({"vertices_coords": [[0, 0, 0]] * 14}, "its vertices_coords are not points [x, y]"),
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
