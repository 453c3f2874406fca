"""Nets with fold angles: what was unfolded is folded up again, convex or not."""

import json

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import InvalidMetric, MeshNote
from isoembed.gluing import embed_net, glue
from isoembed.io.net import read_net, write_net
from places import SHARED

NUMBERS = SHARED / "trials" / "numbers"
ENDINGS = [".json", ".fold"]


def prism(outline, height):
    """The prism over a polygon: vertices and polygonal faces."""
    n = len(outline)
    points = np.array([[*corner, z] for z in (0.0, height) for corner in outline])
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return points, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def dented_cube(depth):
    """A cube with a pyramid cut out of its top."""
    points, faces = prism([[0, 0], [1, 0], [1, 1], [0, 1]], 1.0)
    points = np.vstack([points, [0.5, 0.5, 1 - depth]])
    return points, [faces[0], *faces[2:], *([4 + k, 4 + (k + 1) % 4, 8] for k in range(4))]


SOLIDS = {
    "U prism": (*prism([[0, 0], [5, 0], [5, 3], [4, 3], [4, 1], [1, 1], [1, 2], [0, 2]], 2.0), 16.0),
    "star prism": (*prism([[0, 0], [2, 1], [4, 0], [3, 2], [4, 4], [2, 3], [0, 4], [1, 2]], 1.0), 8.0),
    "dented cube": (*dented_cube(0.4), 1 - 0.4 / 3),
    "cube": (*zoo.cube(), 1.0),
}


def given(points, faces):
    metric = isoembed.PolyhedralMetric.from_mesh(points, faces)
    return isoembed.Embedding(metric, points, method="given", tolerance=1e-10)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("name", SOLIDS)
def test_there_and_back(name, ending, tmp_path):
    points, faces, volume = SOLIDS[name]
    path = tmp_path / f"net{ending}"
    write_net(path, isoembed.unfold(given(points, faces)))
    again = embed_net(read_net(str(path)))
    assert again.residual < 1e-12
    assert again.volume == pytest.approx(volume, rel=1e-12)
    assert again.surface.concave_edges.any() == (name != "cube")


def test_angles_choose_between_a_dent_and_a_bump(tmp_path):
    # A pyramid set upon the cube and one cut out of it have the same lengths.
    for depth in (0.3, -0.3):
        path = tmp_path / "net.json"
        write_net(path, isoembed.unfold(given(*dented_cube(depth))))
        assert embed_net(read_net(str(path))).volume == pytest.approx(1 - depth / 3, rel=1e-12)


@pytest.mark.parametrize("digits", [1, 3])
def test_angles_with_few_digits(digits, tmp_path):
    points, faces, volume = SOLIDS["U prism"]
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    path = tmp_path / "net.json"
    write_net(path, isoembed.unfold(given(points @ turn, faces)))
    net = json.loads(path.read_text())
    for fold in net["folds"][0]:
        fold[2] = round(fold[2] + 0.4 * 10.0**-digits, digits)
    path.write_text(json.dumps(net))
    assert embed_net(read_net(str(path))).volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_precision_of_the_solid_stays_with_its_net(ending, tmp_path):
    points, faces = zoo.cube()
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    solid = given(np.round(points @ turn, 6), faces)
    unfolding = isoembed.unfold(solid)
    path = tmp_path / f"net{ending}"
    write_net(path, unfolding)
    for net in (unfolding.net, read_net(str(path))):
        assert net.precision.name == solid.metric.precision.name
        error = net.precision.length_error * net.mean_length
        assert error == pytest.approx(solid.metric.precision.length_error * solid.metric.mean_length)
        assert int(isoembed.embed(net, method="alexandrov").surface.flat_faces.of_triangles.max()) + 1 == 6


def test_without_folds_a_net_that_is_not_convex_is_refused(tmp_path):
    points, faces, _ = SOLIDS["U prism"]
    unfolding = isoembed.unfold(given(points, faces))
    with pytest.raises(InvalidMetric, match=r"450 degrees, meets at .* lacks its fold angles: \"folds\""):
        embed_net(unfolding.net)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"folds": 3}, "the folds of .* are not 1 lists"),
        ({"folds": [[[0, 1, 90.0]]]}, "is not a fold of polygon 0"),
        ({"folds": [[[0, 99, 90.0]]]}, "is not a fold of polygon 0"),
        ({"folds": [[[0, 3, 190.0]]]}, "is not a fold of polygon 0"),
        ({"sides": [[[0, 99], [0, 1]]]}, "glues side 99 of polygon 0"),
        ({"sides": [[[0, 0, 1], [0, 1]]]}, r"with folds, sides are \[polygon, side\]"),
        ({"sides": [3]}, "are not a list of pairs"),
        ({"precision": {"name": "7 digits"}}, "not a name and a length_error"),
    ],
)
def test_damaged_folds_are_refused(changes, sentence, tmp_path):
    path = tmp_path / "net.json"
    write_net(path, isoembed.unfold(given(*zoo.cube())))
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))
    with pytest.raises(isoembed.io.FileError, match=sentence):
        read_net(str(path))


@pytest.mark.shared
def test_typed_tetrahedron():
    with pytest.warns(MeshNote, match="from the corners, with 6 digits"):
        net = read_net(str(NUMBERS / "02_tetrahedron_net_typed.json"))
    assert embed_net(net).volume == pytest.approx(2**0.5 / 12, abs=1e-6)


@pytest.mark.shared
def test_prism_of_a_fold_file():
    solid = embed_net(read_net(str(NUMBERS / "09_L_prism_net.fold")))
    assert solid.volume == pytest.approx(9.0, rel=1e-12)
    assert isoembed.certify(solid).certified


@pytest.mark.shared
def test_tetrahedron_with_faces_in_any_orientation():
    with pytest.warns(MeshNote, match="2 of 4 faces are reversed"):
        metric = isoembed.io.read_metric(NUMBERS / "10_tetrahedron_any_orientation.json")
    # Heron's formula of space (Cayley-Menger): squares of the lengths from vertex 3 and between the others.
    squares = np.array([[0, 900, 2500, 3600], [900, 0, 1600, 3600], [2500, 1600, 0, 3600], [3600] * 3 + [0]])
    cayley = np.pad(squares, ((1, 0), (1, 0)), constant_values=1.0)
    cayley[0, 0] = 0
    volume = np.sqrt(np.linalg.det(cayley) / 288)
    assert isoembed.embed(metric).volume == pytest.approx(volume, rel=1e-10)


def in_sheets(surface, joins):
    """A surface unfolded into many sheets: only so many folds of its net are kept."""
    net = isoembed.unfold(surface)
    folds = net.corners[0][net.fold_corners[0]].tolist()
    return isoembed.unfold(surface, objective="faces", keep=folds[-joins:])


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize(("name", "joins"), [("U prism", 4), ("star prism", 5), ("dented cube", 4)])
def test_several_sheets_are_put_together(name, joins, ending, tmp_path):
    points, faces, volume = SOLIDS[name]
    cut = in_sheets(given(points, faces), joins)
    assert len(cut.sheets) > 4
    write_net(tmp_path / f"net{ending}", cut)
    net = read_net(str(tmp_path / f"net{ending}"))
    assert net.folded is not None
    assert embed_net(net).volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("digits", [None, 6, 4])
def test_faces_by_themselves_without_folds(digits):
    points, faces, volume = SOLIDS["U prism"]
    net = in_faces(points, faces, digits)
    assert (net.deficits < -0.1).any() and net.folded is None
    solid = embed_net(net)
    assert solid.volume == pytest.approx(volume, rel=1e-12 if digits is None else 10.0 ** (1 - digits))


def in_faces(points, faces, digits):
    """The faces of a solid as a net, turned, each with its corners rounded."""
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    polygons = []
    for face in faces:
        corners = points[face]
        x = corners[1] - corners[0]
        x = x / np.linalg.norm(x)
        normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        y = np.cross(normal / np.linalg.norm(normal), x)
        polygon = np.stack([corners @ x, corners @ y], axis=1) @ turn
        polygons.append(polygon if digits is None else np.round(polygon, digits))
    return glue(polygons, corners=[list(map(int, face)) for face in faces])
