"""Meshes as they come: what is merged, cut and left out, and what is said of it."""

import re
import warnings

import numpy as np
import pytest

import zoo
from isoembed import PolyhedralMetric, embed
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote
from isoembed.metric.curvature import area, deficits
from isoembed.metric.given_mesh import triangle_mesh

CUBE = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
SQUARES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
APART = CUBE[np.concatenate(SQUARES)], np.arange(24).reshape(6, 4)


def messages(function, *arguments, **options):
    """What a function returns, and the notes."""
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        result = function(*arguments, **options)
    assert all(note.category is MeshNote and note.filename == __file__ for note in notes)
    return result, [str(note.message) for note in notes]


def refusal(*arguments, **options):
    with pytest.raises(InvalidMetric) as caught:
        PolyhedralMetric.from_mesh(*arguments, **options)
    return str(caught.value)


def test_polygons_are_counted_as_they_are_given():
    expected = "edge [0, 1] is in 3 faces [0, 2, 6], not in 2: face 6 repeats face 2"
    assert refusal(CUBE, [*SQUARES, SQUARES[2]]).startswith(expected)


@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e12])
def test_planar_polygons_are_faces_of_the_metric(unit):
    metric, notes = messages(PolyhedralMetric.from_mesh, unit * CUBE, SQUARES)
    assert notes == [] and metric.triangulation.n_faces == 12
    solid = embed(metric, method="alexandrov")
    assert sorted(map(len, solid.polygons)) == [4] * 6
    assert solid.volume == pytest.approx(unit**3, rel=1e-12, abs=0)


def test_a_polygon_covered_twice():
    hexagon = [[np.cos(t), np.sin(t), 0] for t in np.arange(6) * np.pi / 3]
    metric = PolyhedralMetric.from_mesh(hexagon, [list(range(6)), list(range(6))[::-1]])
    assert area(metric) == pytest.approx(3 * np.sqrt(3), rel=1e-14)
    assert embed(metric, method="alexandrov").volume == 0


def test_polygons_that_are_not_planar_are_said():
    lifted = CUBE + np.outer(CUBE.all(axis=1), [0.1, 0.1, 0.1])
    metric, (note,) = messages(PolyhedralMetric.from_mesh, lifted, SQUARES)
    assert note.startswith("3 faces are not planar, and replaced by triangles")
    assert re.search(r"the first is face 1, with corners 0\.0[34] of its size off a plane$", note)
    assert deficits(metric).sum() == pytest.approx(4 * np.pi)


def test_vertices_that_coincide_are_named_and_merged():
    sentence = refusal(*APART)
    assert "the surface has 6 components" in sentence
    assert "; 24 vertices coincide with others" in sentence
    assert re.search(r"\(vertex 0 and (8|16)\): merge them with merge=1e-05$", sentence)
    metric, notes = messages(PolyhedralMetric.from_mesh, *APART, merge=0.0)
    assert notes == ["16 vertices are merged with others; the first is vertex 8 with vertex 0"]
    np.testing.assert_allclose(deficits(metric), np.pi / 2, rtol=1e-14)


@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e12])
def test_the_refusal_names_a_tolerance_that_suffices(unit):
    vertices, faces = zoo.icosphere(1)
    noise = np.random.default_rng(1).uniform(-1e-4, 1e-4, (3 * len(faces), 3))
    apart = unit * (vertices[faces].reshape(-1, 3) + noise), np.arange(3 * len(faces)).reshape(-1, 3)
    sentence = refusal(*apart)
    assert "240 vertices nearly coincide" in sentence
    tolerance = float(re.search(r"with merge=(\S+)$", sentence)[1])
    assert 1e-4 < tolerance < 1e-3
    metric, _ = messages(PolyhedralMetric.from_mesh, *apart, merge=tolerance)
    assert metric.triangulation.n_vertices == 42


def test_quads_at_a_pole_of_vertices_that_coincide_name_it():
    corners = np.array([[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]], dtype=float)
    faces = [[0, 2, 3, 1], [0, 3, 4], [0, 4, 2], [4, 3, 2]]
    with pytest.raises(InvalidMetric, match=r"1 side has no length .*vertex 1 to 0.*merge=1e-05"):
        PolyhedralMetric.from_mesh(corners, faces)
    metric, _ = messages(PolyhedralMetric.from_mesh, corners, faces, merge=0.0)
    assert metric.triangulation.n_vertices == 4


def test_no_vertices_are_named_where_merging_does_not_help():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces[1:])
    with pytest.raises(InvalidMetric, match=r"not closed; the face .* may be missing$"):
        metric.triangulation.check_sphere()


def test_merging_is_not_advised_where_a_hole_is_left():
    vertices, faces = APART
    assert refusal(vertices[:20], faces[:5]).endswith(
        "; 20 vertices coincide with others (vertex 0 and 8), but merging them does not close the surface"
    )


def test_sides_without_length_are_no_reason_to_merge_what_then_is_open():
    corners = np.array([[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]], dtype=float)
    with pytest.raises(InvalidMetric) as refused:
        PolyhedralMetric.from_mesh(corners, [[0, 2, 3, 1], [0, 3, 4], [0, 4, 2]])
    assert "merge=" not in str(refused.value)


def test_faces_that_merge_into_edges_are_left_out():
    vertices, faces = zoo.icosahedron()
    a, b = faces[0, :2].tolist()
    inside = np.append(vertices, vertices[[a]], axis=0)  # the edge a, b opened, and filled by two needles
    other = next(f for f, face in enumerate(faces) if {a, b} <= set(face) and f)
    opened = faces.copy()
    opened[other][faces[other] == a] = 12
    c = (set(faces[other].tolist()) - {a, b}).pop()
    needles = np.concatenate([opened, [[b, a, 12], [12, a, c]]])
    assert "has length 0.0" in (sentence := refusal(inside, needles)) and "2 vertices coincide" in sentence
    metric, notes = messages(PolyhedralMetric.from_mesh, inside, needles, merge=0.0)
    needle = [b, a, 12]
    sentence = (
        f"2 faces are reduced to an edge or a point by merging, and left out; the first is face 20 {needle}"
    )
    assert notes[1] == sentence
    np.testing.assert_allclose(metric.lengths, 2.0, rtol=1e-14)
    with pytest.raises(InvalidMetric, match="all have merged"):
        messages(PolyhedralMetric.from_mesh, [[1.0, 1, 1]] * 3, [[0, 1, 2], [2, 1, 0]], merge=0.0)


def test_vertices_in_no_face():
    vertices, faces = np.insert(CUBE, 3, 7.0, axis=0), [[v + (v > 2) for v in face] for face in SQUARES]
    assert "vertex 3 is in no face" in refusal(vertices, faces)
    (points, triangles, _), notes = messages(triangle_mesh, vertices, faces, leave_out=True)
    assert notes == ["1 vertex is in no face, and left out; the first is vertex 3"]
    np.testing.assert_array_equal(points, CUBE)
    np.testing.assert_array_equal(triangles, triangle_mesh(CUBE, SQUARES).triangles)


@pytest.mark.parametrize("merge", [-1e-9, 1.0, np.nan, np.inf, "all"])
def test_tolerances_that_are_none(merge):
    with pytest.raises(InvalidParameter, match=r"not a number of mean edge lengths in \[0, 1\)"):
        PolyhedralMetric.from_mesh(CUBE, SQUARES, merge=merge)


@pytest.mark.parametrize(
    ("faces", "sentence"),
    [
        ([[0, 1, 3, 2], [4, 6]], "face 1 has 2 corners [4, 6], not 3 or more"),
        ([[0, 1, 3, 2], [4, 6, 7.5]], "face 1 refers to vertex 7.5: vertex indices must be whole numbers"),
        ([[0, 1, 3, 2], [4, 6, -7]], "face 1 refers to vertex -7: vertex indices must not be negative"),
        ([[0, 1, 3, 2], [4, 6, True]], "face 1 refers to vertex True: vertex indices must be whole numbers"),
        ([[0, 1, 3, 2], [4, 6, 10**30]], f"face 1 refers to vertex {10**30}: the index is too large"),
        ([[0, 1, 3, 2], 5], "face 1 has 1 corners 5, not 3 or more"),
        ([[0, 1, 3, 2], [4, 6, 8]], "a face refers to vertex 8, but there are only 8 vertices"),
        (np.array([[0, 1], [1, 2]]), "face 0 has 2 corners [0, 1], not 3 or more"),
        (np.zeros((0, 4)), "there are no faces"),
        ([], "there are no faces"),
        (np.array(5), "the faces are array(5), not a list"),
        ([[0, 1, 3, 2], [4, 6, 7, 4]], "face 1 [4, 6, 7, 4] repeats a vertex"),
    ],
)
def test_polygons_that_are_none(faces, sentence):
    assert sentence in refusal(CUBE, faces)


@pytest.mark.parametrize("merge", [None, 0, 1e-5])
def test_coordinates_next_to_the_largest_float(merge):
    metric = PolyhedralMetric.from_mesh(CUBE * 1e308, SQUARES, merge=merge)
    assert metric.mean_length == pytest.approx(1e308 * PolyhedralMetric.from_mesh(CUBE, SQUARES).mean_length)


def test_polygons_need_space():
    assert "face 0 has 4 corners, and the vertices have 2 coordinates" in refusal(CUBE[:, :2], SQUARES)
