"""Polyhedral metrics: what they keep, what they refuse, and that no length is too small or too large."""

import re
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from curved import body
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from isoembed.space.models import from_model, to_model

T = zoo.TETRAHEDRON.tolist()
E = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
L = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5]


def changed(values, index, value):
    return [value if k == index else old for k, old in enumerate(values)]


# ---------------------------------------------------------------- what it keeps


def test_lengths_in_the_order_of_the_edges():
    metric = PolyhedralMetric(T, L)
    assert metric.edges.tolist() == E
    assert metric.lengths.tolist() == L
    assert metric.mean_length == pytest.approx(1.25, rel=1e-15)
    assert metric.face_lengths.tolist() == [
        [1.0, 1.3, 1.1],
        [1.1, 1.5, 1.2],
        [1.2, 1.4, 1.0],
        [1.4, 1.5, 1.3],
    ]
    assert repr(metric) == "PolyhedralMetric(4 vertices, 6 edges, 4 faces, mean edge length 1.25)"


@given(seed=st.integers(0, 10**6))
def test_edges_may_come_in_any_order_and_direction(seed):
    vertices, faces = zoo.random_hull(12, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(metric.edges))
    edges = rng.permuted(metric.edges[order], axis=1)
    assert np.array_equal(PolyhedralMetric(faces, metric.lengths[order], edges).lengths, metric.lengths)


def test_an_edge_given_twice_with_one_length_is_fine():
    metric = PolyhedralMetric(T, [*L, 1.2 * (1 + 1e-15)], [*E, [3, 0]])
    assert metric.lengths.tolist() == L


def test_from_mesh_measures_the_edges():
    vertices, faces = zoo.icosahedron()
    metric = PolyhedralMetric.from_mesh(vertices @ zoo.rotation(0).T + 3.0, faces)
    assert metric.lengths == pytest.approx(np.full(30, 2.0), rel=1e-14)


@pytest.mark.parametrize("scale", [1e-150, 1e-12, 1e12, 1e150, 1e300])
def test_any_scale_is_ordinary(scale):
    vertices, faces = zoo.random_hull(20, 0)
    metric, unit = (
        PolyhedralMetric.from_mesh(scale * vertices, faces),
        PolyhedralMetric.from_mesh(vertices, faces),
    )
    assert metric.lengths / scale == pytest.approx(unit.lengths, rel=1e-14)
    assert metric.mean_length / scale == pytest.approx(unit.mean_length, rel=1e-14)
    assert 1 <= metric.normalized.mean_length < 2
    assert (metric.normalized.lengths * metric.unit == metric.lengths).all()  # no rounding either way
    assert metric.normalized.normalized is metric.normalized


def test_with_lengths_keeps_the_triangulation():
    metric = PolyhedralMetric(T, L)
    other = metric.with_lengths(2 * metric.lengths)
    assert other.triangulation is metric.triangulation
    assert other.lengths.tolist() == [2 * length for length in L]
    with pytest.raises(InvalidMetric, match=r"edge 1 \[0, 2\] has length -1.1"):
        metric.with_lengths(-metric.lengths * [-1, 1, 1, 1, 1, 1])


def test_the_input_is_copied_and_the_metric_is_read_only():
    lengths = np.array(L)
    metric = PolyhedralMetric(T, lengths)
    lengths[0] = 7.0
    assert metric.lengths[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        metric.lengths[0] = 7.0
    with pytest.raises(AttributeError):
        metric.lengths = lengths


def test_the_thinnest_triangle_that_floats_allow_is_a_triangle():
    almost = np.nextafter(2.0, 0.0)
    lengths = [almost, 1.0, 1.0, 1.0, 1.0, 1.0]
    assert PolyhedralMetric(T, lengths).lengths[0] == almost
    with pytest.raises(InvalidMetric, match="breaks the triangle inequality"):
        PolyhedralMetric(T, [2.0, *lengths[1:]])


def test_lengths_at_the_end_of_the_floats_do_not_overflow():
    metric = PolyhedralMetric(T, [1.7e308, 1e308, 1e308, 1e308, 1e308, 1e308])
    assert metric.mean_length == pytest.approx(1.7e308 / 6 + 1e308 * (5 / 6), rel=1e-15)


# ---------------------------------------------------------------- refusals

REFUSALS = {
    "zero": (T, changed(L, 2, 0.0), None, "edge 2 [0, 3] has length 0.0, not a positive finite"),
    "negative": (T, changed(L, 3, -1.3), None, "edge 3 [1, 2] has length -1.3, not a positive finite"),
    "infinite": (T, changed(L, 1, np.inf), None, "edge 1 [0, 2] has length inf, not a positive finite"),
    "nan": (T, changed(L, 5, np.nan), None, "edge 5 [2, 3] has length nan, not a positive finite"),
    "two offenders": (T, changed(changed(L, 4, 0.0), 2, -1.0), None, "edge 2 [0, 3] has length -1.0"),
    "triangle": (
        T, changed(L, 0, 2.5), None,
        "face 0 [0, 1, 2] breaks the triangle inequality: its sides are 1.1, 1.3 and 2.5",
    ),
    "flat triangle": (T, [2.0, 1, 1, 1, 1, 1], None, "face 0 [0, 1, 2] breaks the triangle inequality"),
    "string": (T, changed(L, 0, "a"), None, "'a'"),
    "integer beyond floats": (T, changed(L, 0, 10**400), None, "edge 0 has length 1000"),
    "complex": (T, [1j] * 6, None, "edge 0 has length 1j, not a finite number"),
    "masked": (T, np.ma.masked_equal([1, 1, 1, 1, 1, 1.5], 1.5), None, "edge 5 has a masked length"),
    "table": (T, [L], None, "the lengths have shape (1, 6), not (E,)"),
    "ragged": (T, [[1.0], [1.0, 2.0]], None, "edge 1 has 2 lengths, edge 0 has 1"),
    "scalar": (T, 1.0, None, "the lengths have shape (), not (E,)"),
    "too few": (T, L[:5], None, "there are 6 edges but 5 lengths"),
    "too many": (T, [*L, 1.0], None, "there are 6 edges but 7 lengths"),
    "none": (T, [], None, "there are 6 edges but 0 lengths"),
    "missing edge": (T, L[:5], E[:5], "edge [2, 3] of face 1 has no length"),
    "missing, one twice": (T, changed(L, 5, 1.0), [*E[:5], [1, 0]], "edge [2, 3] of face 1 has no length"),
    "extra edge": (T, [*L, 1.0], [*E, [0, 7]], "edge 6 [0, 7] is in no face"),
    "loop": (T, [*L, 1.0], [*E, [2, 2]], "edge 6 [2, 2] is in no face"),
    "huge end": (T, [*L, 1.0], [*E, [2, 10**18]], "edge 6 [2, 1000000000000000000] is in no face"),
    "conflict": (
        T, [*L, 2.0], [*E, [1, 0]],
        "edge 6 [1, 0] has length 2.0, but edge 0 is the same edge and has 1.0",
    ),
    "edges and lengths": (T, L, E[:5], "there are 5 edges but 6 lengths"),
    "no edges": (T, [], [], "there are no edges"),
    "negative end": (T, L, [*E[:5], [2, -3]], "edge 5 refers to vertex -3: vertex indices must not be"),
    "fractional end": (T, L, [*E[:5], [2, 2.5]], "edge 5 refers to vertex 2.5: vertex indices must be whole"),
    "three ends": (T, L, [[0, 1, 2]] * 6, "edge 0 has 3 ends [0, 1, 2], not 2"),
    "bad length in the user's order": (T, changed(L, 1, 0.0), E[::-1], "edge 1 [1, 3] has length 0.0"),
}  # fmt: skip


@pytest.mark.parametrize(("faces", "lengths", "edges", "sentence"), REFUSALS.values(), ids=REFUSALS.keys())
def test_refusals_name_the_first_offender(faces, lengths, edges, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)) as refusal:
        PolyhedralMetric(faces, lengths, edges)
    assert "\n" not in str(refusal.value)


VERTICES = zoo.tetrahedron()[0]

MESH_REFUSALS = {
    "nan": (
        np.where(np.arange(12).reshape(4, 3) == 7, np.nan, VERTICES),
        "vertex 2 has the coordinates [-1.0, nan,",
    ),
    "too few": (VERTICES[:3], "a face refers to vertex 3, but there are only 3 vertices"),
    "too many": (np.vstack([VERTICES, VERTICES[:1]]), "vertex 4 is in no face"),
    "coincident": (np.vstack([VERTICES[:3], VERTICES[:1]]), "edge 2 [0, 3] has length 0.0"),
    "all at one point": (np.zeros((4, 3)), "edge 0 [0, 1] has length 0.0"),
    "flat list": (VERTICES.ravel(), "the vertices have shape (12,), not (V, 3)"),
    "strings": ([["a", "b", "c"]] * 4, "vertex 0 has coordinate 'a', not a finite number"),
    "masked": (np.ma.masked_equal(np.arange(12.0).reshape(4, 3), 7), "vertex 2 has a masked coordinate"),
    "ragged": ([[0.0, 1.0, 2.0], [1.0, 2.0]], "vertex 1 has 2 coordinates, vertex 0 has 3"),
}


@pytest.mark.parametrize(("vertices", "sentence"), MESH_REFUSALS.values(), ids=MESH_REFUSALS.keys())
def test_meshes_that_are_refused(vertices, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        PolyhedralMetric.from_mesh(vertices, T)


def test_a_mesh_keeps_triangles_whose_height_the_lengths_lose():
    # A vertex 1e-9 from an edge of a tetrahedron: in floats, the sides there are as long as the edge.
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    inside = corners[0] / 3 + 2 * corners[1] / 3
    inside += 1e-9 * (corners[2] - inside)
    faces = [[0, 1, 4], [1, 2, 4], [2, 0, 4], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    metric = PolyhedralMetric.from_mesh(np.vstack([corners, inside]), faces)
    chords = np.linalg.norm(np.diff(np.vstack([corners, inside])[metric.edges], axis=1)[:, 0], axis=1)
    assert np.abs(metric.lengths - chords).max() < 1e-14
    on_the_edge = np.vstack([corners, [[1, 0, 0]]])  # the middle: no height at all
    with pytest.raises(InvalidMetric, match=r"face 0 \[0, 1, 4\] breaks the triangle inequality"):
        PolyhedralMetric.from_mesh(on_the_edge, faces)


# In curved spaces

LARGE = {
    "side on the sphere": (
        1.0, [3.2, *[2.0] * 5],
        "edge 0 [0, 1] has length 3.2, not below 3.14159265, half of a great circle of the sphere of "
        "curvature 1",
    ),
    "perimeter on the sphere": (
        4.0, [1.1] * 6,
        "face 0 [0, 1, 2] has the perimeter 3.3000000000000003, not below 3.14159265, a great circle of the "
        "sphere of curvature 4",
    ),
    "hyperbolic": (
        -4.0, [36.0] * 6,
        "edge 0 [0, 1] has length 36.0, which is 72 radii of curvature: beyond 70 floats do not tell the "
        "angles of hyperbolic triangles from zero",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("curvature", "lengths", "sentence"), LARGE.values(), ids=LARGE.keys())
def test_triangles_that_are_too_large(curvature, lengths, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        PolyhedralMetric(T, lengths, curvature=curvature)


@pytest.mark.parametrize("k", [-1.0, 0.7])
def test_lengths_of_meshes_in_any_model(k):
    x, faces, _ = body(20, 0, k, 2.0)
    space = Space(k)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=k)
    assert metric.space == space and metric.curvature == k
    assert metric.lengths == pytest.approx(space.distances(*x[metric.edges].swapaxes(0, 1)), rel=1e-14)
    for model in ("conformal", "projective"):
        p = to_model(space, x, model)
        again = PolyhedralMetric.from_mesh(p, faces, curvature=k, model=model)
        assert again.lengths == pytest.approx(metric.lengths, rel=1e-13)
    assert metric.scaled(3.0).space == space.scaled(3.0)
    assert metric.scaled(3.0).with_lengths(metric.lengths).curvature == pytest.approx(k / 9)
    assert metric.normalized.curvature == k * metric.unit**2


def test_polygons_are_cut_along_straight_lines():
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # that faces are not planar
        metric = PolyhedralMetric.from_mesh(corners, squares, curvature=-1.0)
        assert len(metric.faces) == 12
        bent = corners * np.where(np.arange(8) == 0, 0.7, 1.0)[:, None]
        with pytest.raises(MeshNote, match="3 faces are not planar"):
            PolyhedralMetric.from_mesh(bent, squares, curvature=-1.0)


def test_meshes_that_are_not_in_the_model():
    with pytest.raises(InvalidParameter, match=r"1\.73205081 from the center of the projective model"):
        PolyhedralMetric.from_mesh(VERTICES, T, curvature=-1.0, model="projective")
    with pytest.raises(
        InvalidParameter, match="the model is 'klein', none of conformal, projective, ambient"
    ):
        PolyhedralMetric.from_mesh(VERTICES, T, curvature=-1.0, model="klein")
    with pytest.raises(InvalidMetric, match=re.escape("the vertices have shape (4, 2), not (V, 3)")):
        PolyhedralMetric.from_mesh(VERTICES[:, :2], T, curvature=-1.0)


@pytest.mark.parametrize("k", [-1.0, 1.0])
def test_a_mesh_in_curved_space_keeps_triangles_whose_height_the_lengths_lose(k):
    corners = 0.4 * np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    inside = corners[0] / 3 + 2 * corners[1] / 3
    inside += 1e-9 * (corners[2] - inside)
    faces = [[0, 1, 4], [1, 2, 4], [2, 0, 4], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    p = np.vstack([corners, inside])
    metric = PolyhedralMetric.from_mesh(p, faces, curvature=k, model="projective")
    x = from_model(Space(k), p, "projective")
    assert np.abs(metric.lengths - Space(k).distances(*x[metric.edges].swapaxes(0, 1))).max() < 1e-14
