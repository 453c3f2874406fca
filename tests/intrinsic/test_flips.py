"""Intrinsic flips: against the metric that they must not change."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import curved
import zoo
from isoembed import PolyhedralMetric
from isoembed.intrinsic import delaunay_loops
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.delaunay_loops import tilt, tilts
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.metric.curvature import deficits
from isoembed.metric.delaunay import delaunay
from isoembed.metric.glued import GluedMetric
from isoembed.metric.triangles import Triangles
from isoembed.space import Space
from isoembed.space.trigonometry import angle_between, apex, twice_area
from scrambling import scramble


def tables_of(metric):
    return GluedMetric.of(metric).half_edges()


def non_delaunay_edges(tables, weights):
    return delaunay_loops.non_delaunay_edges(tables.views, weights)


def assert_consistent(tables):
    every = np.arange(tables.twins.size)
    assert np.array_equal(tables.twins[tables.twins], every)
    assert not (tables.twins == every).any()
    assert np.array_equal(tables.lengths[tables.twins], tables.lengths)
    assert np.array_equal(np.roll(tables.faces, -1, axis=1).ravel()[tables.twins], tables.corners)


def angle_sums(tables):
    return np.bincount(tables.corners, Triangles.of(tables.face_lengths).angles.ravel())


def modulo(difference, period):
    """Distance to the nearest multiple."""
    return np.abs((difference / period + 0.5) % 1 - 0.5) * period


@given(st.integers(4, 40), st.integers(0, 10**6))
def test_flips_keep_the_metric(n, seed):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(n, seed))
    tables = tables_of(metric)
    scramble(tables, 20 * n, np.random.default_rng(seed))
    assert_consistent(tables)
    assert 2 * np.pi - angle_sums(tables) == pytest.approx(deficits(metric), abs=1e-10)
    areas = Triangles.of(tables.face_lengths)
    before = Triangles.of(metric.face_lengths)
    assert (areas.areas * areas.unit**2).sum() == pytest.approx(
        (before.areas * before.unit**2).sum(), rel=1e-11
    )


@given(st.integers(4, 40), st.integers(0, 10**6))
def test_delaunay_does_not_depend_on_the_triangles(n, seed):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(n, seed))
    tables, scrambled = tables_of(metric), tables_of(metric)
    scramble(scrambled, 20 * n, np.random.default_rng(seed))
    for t in (tables, scrambled):
        _, stuck = make_delaunay(t, np.zeros(n))
        assert stuck == 0 and non_delaunay_edges(t, np.zeros(n)).size == 0
    assert np.sort(scrambled.lengths) == pytest.approx(np.sort(tables.lengths), rel=1e-10)


def test_flips_do_the_same_without_directions():
    given = GluedMetric.of(PolyhedralMetric.from_mesh(*zoo.random_hull(60, 3)))
    directed, plain = given.half_edges(), given.half_edges(directed=False)
    for tables in (directed, plain):
        make_delaunay(tables, np.zeros(60))
    assert plain.copy().directions.size == plain.in_order(np.arange(60)).directions.size == 0
    assert not np.array_equal(directed.corners, given.faces.ravel())
    for name in ("corners", "twins", "lengths"):
        assert np.array_equal(getattr(plain, name), getattr(directed, name))


def test_delaunay_agrees_with_the_flips_of_triangulations():
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(60, 3))
    tables = tables_of(metric)
    make_delaunay(tables, np.zeros(60))
    assert np.sort(tables.lengths)[::2] == pytest.approx(np.sort(delaunay(metric).lengths), rel=1e-12)


@given(st.integers(0, 10**6))
def test_directions_survive_flips(seed):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(20, seed))
    tables = tables_of(metric)
    ends = np.roll(tables.faces, -1, axis=1).ravel()
    before = dict(zip(zip(tables.corners, ends, strict=True), tables.directions, strict=True))
    scramble(tables, 200, np.random.default_rng(seed))
    total = angle_sums(tables)
    # Around every vertex the next half-edge's direction is larger by the angle between them.
    angles = Triangles.of(tables.face_lengths).angles.ravel()
    into = np.roll(np.arange(tables.corners.size).reshape(-1, 3), 1, axis=1).ravel()
    turned = tables.directions[tables.twins[into]] - tables.directions - angles
    assert modulo(turned, total[tables.corners]).max() < 1e-11
    # And back on the Delaunay triangulation, an edge that was there leaves as it did.
    make_delaunay(tables, np.zeros(20))
    other = tables_of(metric)
    make_delaunay(other, np.zeros(20))
    lengths = dict(zip(zip(other.corners, np.roll(other.faces, -1, axis=1).ravel(), strict=True),
                       zip(other.lengths, other.directions, strict=True), strict=True))  # fmt: skip
    assert before
    for i, j, l, direction in zip(
        tables.corners,
        np.roll(tables.faces, -1, axis=1).ravel(),
        tables.lengths,
        tables.directions,
        strict=True,
    ):
        l_other, direction_other = lengths[i, j]
        if abs(l - l_other) < 1e-9:
            assert modulo(direction - direction_other, total[i]) < 1e-9


@given(st.integers(0, 10**6))
def test_weighted_delaunay_is_the_lower_hull(seed):
    # Lift the points of a disc by |x|^2 - w: the lower hull projects to the weighted Delaunay triangulation.
    # Glue two such discs along their common boundary.
    rng = np.random.default_rng(seed)
    outline = np.array([[np.cos(a), np.sin(a)] for a in 2 * np.pi * np.arange(8) / 8])
    faces, twins, lengths = zoo.doubly_covered(outline)
    weights = rng.uniform(-0.2, 0.2, 8)
    tables = HalfEdges.of(faces, twins, lengths)
    make_delaunay(tables, weights)
    lifted = np.column_stack([outline, (outline**2).sum(axis=1) - weights])
    hull = ConvexHull(lifted)
    lower = {tuple(sorted(f)) for f, e in zip(hull.simplices, hull.equations, strict=True) if e[2] < -1e-9}
    front = {tuple(sorted(f.tolist())) for f in tables.faces}
    assert lower <= front


@pytest.mark.parametrize("curvature", [-1.0, 1.0, -1e-14, 1e-14])
@pytest.mark.parametrize("size", [1e-2, 1.0, 3.0])
@given(st.integers(4, 40), st.integers(0, 10**6))
def test_triangles_of_convex_bodies_in_space_are_found_again(curvature, size, n, seed):
    x, faces, _ = curved.body(n, seed, curvature, size)
    tables, weights = curved.tables_in(x, faces, curvature), curved.weights_in(x, curvature)
    before = tables.copy()
    assert non_delaunay_edges(tables, weights).size == 0
    scramble(tables, 20 * n, np.random.default_rng(seed))
    assert_consistent(tables)
    assert curved.angle_sums(tables) == pytest.approx(curved.angle_sums(before), abs=1e-10)
    assume(tables.lengths.max() <= 20.0 / np.sqrt(abs(curvature)))  # of longer sides exp has no digits left
    assert make_delaunay(tables, weights)[1] == 0
    assert {tuple(sorted(f)) for f in tables.faces.tolist()} == {tuple(sorted(f)) for f in faces.tolist()}
    assert np.sort(tables.lengths) == pytest.approx(np.sort(before.lengths), rel=1e-9)


@pytest.mark.parametrize("curvature", [-1.0, 1.0])
def test_tilts_are_those_of_the_apex(curvature):
    # sn(distance of the apex from the line) cos(angle between triangle and apex), by linear algebra.
    x, faces, _ = curved.body(12, 3, curvature, 2.0)
    tables, weights = curved.tables_in(x, faces, curvature), curved.weights_in(x, curvature)
    space = Space(curvature)
    form = np.array([1.0, 1, 1, 1 / curvature])  # <X, X> = 1 / k, the last coordinate being w
    points = np.column_stack([x, space.heights(x)])
    center = space.center(x)
    apex = np.append(center, space.heights(center))
    values, errors = tilts(tables.views, weights)
    for h in range(tables.corners.size):
        f, c = divmod(h, 3)
        i, j, k = (points[v] for v in np.roll(faces[f], -c))
        line = np.array([i, j])
        inner = k - line.T @ np.linalg.solve(line * form @ line.T, line * form @ k)
        expected = (inner * form) @ apex / np.sqrt(inner * form @ inner)
        assert values[h] == pytest.approx(expected, abs=1e-13)
        assert tilt(h, tables.views, weights) == pytest.approx((expected, errors[h]), abs=1e-13)


def test_tilts_tend_to_those_of_the_plane():
    x, faces, _ = curved.body(12, 3, 0.0, 2.0)
    flat = tilts(curved.tables_in(x, faces, 0.0).views, curved.weights_in(x, 0.0))[0]
    for curvature in (-1e-13, 1e-13):
        bent = tilts(curved.tables_in(x, faces, curvature).views, curved.weights_in(x, curvature))[0]
        assert bent == pytest.approx(flat, abs=1e-12)


def test_a_hidden_vertex_is_reported():
    metric = PolyhedralMetric.from_mesh(*zoo.octahedron())
    weights = np.zeros(6)
    weights[0] = 10.0  # farther from the center than its neighbors and the edges to them allow
    _, stuck = make_delaunay(tables_of(metric), -weights)
    assert stuck > 0


def test_a_triangle_glued_to_itself_is_not_flipped():
    # Two triangles, each folded shut along two sides, joined by their third.
    tables = HalfEdges.of(
        np.array([[0, 0, 1], [0, 0, 2]]), np.array([3, 2, 1, 0, 5, 4]), np.array([[1.0, 1.0, 1.0]] * 2)
    )
    before = tables.copy()
    assert scramble(tables, 50, np.random.default_rng(0)) > 0  # the loop between them can be
    assert_consistent(tables)
    assert angle_sums(tables) == pytest.approx(angle_sums(before), abs=1e-12)


def test_flips_there_and_back():
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(12, 5))
    tables = tables_of(metric)
    h = int(np.flatnonzero([scramble(tables.copy(), 1, _Always(h)) for h in range(tables.twins.size)])[0])
    flipped = tables.copy()
    scramble(flipped, 1, _Always(h))
    new = int(np.flatnonzero(~np.isin(flipped.lengths, tables.lengths))[0])
    scramble(flipped, 1, _Always(new))
    assert np.sort(flipped.lengths) == pytest.approx(np.sort(tables.lengths), rel=1e-13)


class _Always:
    """A generator that has one answer."""

    def __init__(self, answer):
        self.answer = answer

    def integers(self, low, high, size):
        return np.full(size, self.answer)


def test_needles_keep_their_angles():
    a, b, c = 1.0, 1.0, 1e-9
    assert angle_between(a, b, c, 0.0) == pytest.approx(1e-9, rel=1e-12)
    assert twice_area(a, b, c) == pytest.approx(1e-9, rel=1e-12)
    assert twice_area(1.0, 2.0, 4.0) == 0.0
    x, y = apex(3.0, 4.0, 5.0, 0.0)
    assert (x, y) == pytest.approx((3.0, 4.0), rel=1e-15)
