"""Flat vertices are taken out, whatever the triangles, and the metric stays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import curved
import zoo
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.flat_vertices import remove_flat_vertices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.insert_vertices import insert_vertices
from scrambling import scramble
from sprinkled import box, checked, doubled, sprinkled, tables_of, turning_errors


@pytest.mark.parametrize("n", [2, 3, 8, 16])
def test_of_a_grid_on_a_cube_the_corners_are_left(n):
    vertices, faces, flat = box(n)
    tables = tables_of(vertices, faces)
    before = tables.copy()
    core, removal = remove_flat_vertices(tables, flat)
    metric = checked(core)
    assert metric.n_vertices == 8
    assert metric.deficits == pytest.approx(np.full(8, np.pi / 2), abs=1e-13)
    assert np.sort(core.lengths) == pytest.approx([1.0] * 24 + [2**0.5] * 12, rel=1e-13)
    assert turning_errors(core).max() < 1e-13
    assert np.array_equal(removal.core, np.flatnonzero(~flat))
    assert np.array_equal(np.sort(removal.removed), np.flatnonzero(flat))
    for table in ("corners", "twins", "lengths", "directions"):
        assert np.array_equal(getattr(tables, table), getattr(before, table))


@given(st.integers(4, 20), st.integers(0, 80), st.integers(0, 10**6), st.sampled_from([1.0, 30.0, 1000.0]))
def test_the_metric_of_the_others_stays(n, m, seed, length):
    body, hull = zoo.random_hull(n, seed)
    body = body * [length, 1, 1]
    vertices, faces, flat = sprinkled(body, hull, m, seed)
    tables = tables_of(vertices, faces)
    scramble(tables, 4 * len(vertices), np.random.default_rng(seed), 1e-2)
    core, _ = remove_flat_vertices(tables, flat)
    make_delaunay(core, np.zeros(n))
    alone = tables_of(body, hull)
    make_delaunay(alone, np.zeros(n))
    # Each of some hundred flips rounds the long edges, and needles pass that on to short ones.
    assert np.sort(core.lengths) == pytest.approx(np.sort(alone.lengths), abs=1e-9 * length)
    old = [int(np.flatnonzero((body == v).all(axis=1))[0]) for v in vertices[~flat]]
    assert checked(core).deficits == pytest.approx(checked(alone).deficits[old], abs=1e-6)


@pytest.mark.parametrize("curvature", [-1.0, 1.0, -1e-14])
@pytest.mark.parametrize("size", [1e-2, 1.0, 3.0])
@given(st.integers(4, 20), st.integers(0, 60), st.integers(0, 10**6), st.sampled_from([1.0, 30.0]))
def test_in_hyperbolic_and_spherical_space(curvature, size, n, m, seed, aspect):
    x, faces, flat = curved.body(n, seed, curvature, size, m, aspect)
    tables = curved.tables_in(x, faces, curvature)
    sums = curved.angle_sums(tables)
    scramble(tables, 4 * len(x), np.random.default_rng(seed), 1e-2)
    core, _ = remove_flat_vertices(tables, flat)
    assert core.curvature == curvature
    assert curved.angle_sums(core) == pytest.approx(sums[~flat], abs=1e-7)
    core, _ = curved.polyhedron_in(core, x[~flat])
    assert core.lengths == pytest.approx(curved.distances_in(core, x[~flat]), abs=1e-9 * size)


def test_directions_at_the_others_stay():
    body, hull = zoo.random_hull(12, 5)
    vertices, faces, flat = sprinkled(body, hull, 60, 5)
    core, removal = remove_flat_vertices(tables_of(vertices, faces), flat)
    assert turning_errors(core).max() < 1e-11
    # With nothing removed, they are the same up to whole turns; a vertex put back is seen where it was.
    restored = insert_vertices(core, removal, np.zeros(core.twins.size, dtype=bool)).tables
    before = tables_of(vertices, faces)
    total = 2 * np.pi - checked(before).deficits
    known = {
        (a, b): direction
        for a, b, direction in zip(
            before.corners.tolist(), before.corners[before.twins].tolist(), before.directions, strict=True
        )
    }
    found = 0
    for a, b, direction in zip(
        restored.corners.tolist(), restored.corners[restored.twins].tolist(), restored.directions, strict=True
    ):
        if (a, b) in known:
            turns = (direction - known[a, b]) / total[a]
            assert abs(turns - round(turns)) < 1e-11
            found += 1
    assert found > 50


@pytest.mark.parametrize("seed", range(40))
def test_polygons_covered_twice(seed):
    # At their narrow ends many edges are loops.
    points, sheets = doubled(4 + seed % 2, seed, length=30.0)
    vertices, faces, flat = sprinkled(points, sheets, 12, seed)
    tables = tables_of(vertices, faces)
    core, _ = remove_flat_vertices(tables, flat)
    assert checked(core).n_vertices == len(points)
    assert checked(core).deficits == pytest.approx(checked(tables).deficits[~flat], abs=1e-7)
    scramble(tables, 100, np.random.default_rng(seed), 1e-2)
    again, _ = remove_flat_vertices(tables, flat)
    assert np.sort(again.lengths) == pytest.approx(np.sort(core.lengths), abs=1e-8)


def test_down_to_a_triangle_covered_twice():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [2, 3, 0], [2, 1, 0], [2, 1, 0]])
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]])
    vertices, faces, flat = sprinkled(points, faces, 30, 0)
    flat |= (vertices == points[3]).all(axis=1)
    core, _ = remove_flat_vertices(tables_of(vertices, faces), flat)
    assert core.corners.size == 6
    assert np.sort(core.lengths) == pytest.approx([13**0.5] * 4 + [4] * 2, rel=1e-13)


def test_many_edges_at_a_flat_vertex():
    n = 200
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    vertices = np.concatenate(
        [np.column_stack([rim, np.full(n, z)]) for z in (0.0, 0.1)] + [[[0.0, 0, 0], [0, 0, 0.1]]]
    )
    bottom, top = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    faces = np.concatenate(
        [
            np.column_stack(face)
            for face in ((i, j, n + j), (i, n + j, n + i), (j, i, bottom), (n + i, n + j, top))
        ]
    )
    core, _ = remove_flat_vertices(tables_of(vertices, faces), np.arange(2 * n + 2) >= 2 * n)
    assert checked(core).deficits == pytest.approx(np.full(2 * n, 2 * np.pi / n), abs=1e-10)


def fold(place, width=0.5, curvature=0.0):
    """A triangle folded shut around vertex 1, another around vertex 2; vertex 3 is to be on the first."""
    faces, twins = np.array([[0, 0, 1], [0, 0, 2]]), np.array([3, 2, 1, 0, 5, 4])
    tables = HalfEdges.of(faces, twins, np.array([[width, 1.0, 1.0], [width, 2.0, 2.0]]), curvature)
    _, removal = remove_flat_vertices(tables, np.zeros(3, dtype=bool))
    start, offset, far = place
    one = {
        "removed": np.array([3]),
        "anchors": tables.corners[[start]],
        "directions": tables.directions[[start]] + offset,
        "distances": np.array([far]),
        "backs": np.array([0.25]),
    }
    return tables, type(removal)(removal.core, **one)


@pytest.mark.parametrize("place", [(1, 0.0, 0.5), (1, 0.0, 0.9), (2, 0.0, 0.7), (2, 0.1, 0.6), (1, 0.2, 0.3)])
def test_a_loop_around_the_tip_of_a_fold(place):
    tables, removal = fold(place)
    kept = np.zeros(6, dtype=bool)
    with_fourth = insert_vertices(tables, removal, kept).tables
    assert checked(with_fourth).deficits == pytest.approx([*checked(tables).deficits, 0], abs=1e-13)
    assert turning_errors(with_fourth).max() < 1e-13
    back, again = remove_flat_vertices(with_fourth, np.array([False, False, False, True]))
    make_delaunay(tables, np.zeros(3))
    assert np.sort(back.lengths) == pytest.approx(np.sort(tables.lengths), rel=1e-13)
    assert checked(back).deficits == pytest.approx(checked(tables).deficits, abs=1e-13)
    assert turning_errors(back).max() < 1e-13
    # The frames are still those of the beginning.
    found = insert_vertices(back, again, kept)
    assert np.sort(found.tables.lengths) == pytest.approx(np.sort(with_fourth.lengths), rel=1e-12)


@pytest.mark.parametrize("curvature", [-1.0, 1.0])
@pytest.mark.parametrize("place", [(1, 0.0, 0.5), (1, 0.0, 0.9), (2, 0.0, 0.7), (2, 0.1, 0.6), (1, 0.2, 0.3)])
def test_a_loop_around_the_tip_of_a_curved_fold(place, curvature):
    tables, removal = fold(place, curvature=curvature)
    sums = curved.angle_sums(tables)
    with_fourth = insert_vertices(tables, removal, np.zeros(6, dtype=bool)).tables
    assert curved.angle_sums(with_fourth) == pytest.approx([*sums, 2 * np.pi], abs=1e-13)
    back, again = remove_flat_vertices(with_fourth, np.array([False, False, False, True]))
    make_delaunay(tables, np.zeros(3))
    assert np.sort(back.lengths) == pytest.approx(np.sort(tables.lengths), rel=1e-13)
    assert curved.angle_sums(back) == pytest.approx(sums, abs=1e-13)
    found = insert_vertices(back, again, np.zeros(6, dtype=bool))
    assert np.sort(found.tables.lengths) == pytest.approx(np.sort(with_fourth.lengths), rel=1e-12)


def test_nothing_flat():
    vertices, faces = zoo.random_hull(20, 0)
    tables = tables_of(vertices, faces)
    core, removal = remove_flat_vertices(tables, np.zeros(20, dtype=bool))
    make_delaunay(tables, np.zeros(20))
    assert np.array_equal(core.corners, tables.corners)
    assert removal.removed.size == 0


def test_triangles_lost_in_rounding_are_refused():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0], [0.5, 3e-10, 0], [0.5, 3e-10, 0]])
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]])
    regular = tables_of(points * [1, 1e9, 1], faces)
    ends = points[regular.corners], points[regular.corners[regular.twins]]
    thin = HalfEdges.of(
        regular.faces, regular.twins, np.linalg.norm(ends[0] - ends[1], axis=1).reshape(-1, 3)
    )
    with pytest.raises(InvalidMetric, match=r"vertex [34] is flat, but the triangles around it are so thin"):
        remove_flat_vertices(thin, np.arange(5) > 2)
