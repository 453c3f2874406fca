"""Edges drawn across other triangles of the same metric."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import curved
import zoo
from isoembed.intrinsic.edge_paths import edge_paths
from isoembed.intrinsic.flat_vertices import remove_flat_vertices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.insert_vertices import insert_vertices
from isoembed.intrinsic.polygons import lay_out
from scrambling import scramble
from sprinkled import box, checked, distances, polyhedron, sprinkled, tables_of


def all_edges(tables):
    return np.flatnonzero(np.arange(tables.twins.size) < tables.twins)


def drawn(original, final, halfedges):
    """Edges of one triangulation on another, of which every triangle is a polygon."""
    return edge_paths(original, final, lay_out(final, np.ones(final.twins.size, dtype=bool)), halfedges)


def mismatch(paths):
    """Largest difference between length and distance, over the mean length."""
    return np.abs(paths.distances - paths.lengths).max() / paths.lengths.mean()


def test_on_its_own_triangles_an_edge_crosses_nothing():
    vertices, faces = zoo.random_hull(30, 2)
    tables = tables_of(vertices, faces)
    edges = all_edges(tables)
    paths = drawn(tables, tables, edges)
    assert paths.halfedges.size == 0 and paths.unresolved.size == 0
    assert np.array_equal(paths.lengths, tables.lengths[edges])
    assert mismatch(paths) < 1e-15
    ends = np.column_stack([tables.corners[edges], tables.corners[tables.twins[edges]]])
    assert np.array_equal(paths.ends, ends)
    assert np.array_equal(paths.point_offsets, 2 * np.arange(len(edges) + 1))
    assert np.array_equal(paths.points(vertices), vertices[ends].reshape(-1, 3))


def test_one_flip_in_a_square():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, -1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]])
    tables = tables_of(vertices, faces)
    flipped = tables.copy()
    diagonal = 2  # 2 -> 0
    scramble(flipped, 1, _One(diagonal))
    paths = drawn(tables, flipped, np.array([diagonal, 0, 3]))
    assert paths.offsets.tolist() == [0, 1, 1, 2]
    assert paths.ends.tolist() == [[2, 0], [0, 1], [0, 2]]
    crossed = flipped.corners[paths.halfedges], flipped.corners[flipped.twins[paths.halfedges]]
    assert {tuple(sorted(pair)) for pair in zip(*crossed, strict=True)} == {(1, 3)}
    assert paths.parameters == pytest.approx([0.5, 0.5], rel=1e-15)
    points = paths.points(vertices)
    assert points[:3] == pytest.approx(np.array([[1, 1, 0], [0.5, 0.5, 0], [0, 0, 0]]), abs=1e-15)
    assert points[5:] == pytest.approx(np.array([[0, 0, 0], [0.5, 0.5, 0], [1, 1, 0]]), abs=1e-15)
    # A path is crossed from the face that it leaves: it is to the left of the half-edge.
    lower = paths.halfedges[0] // 3
    assert 2 in flipped.faces[lower]


class _One:
    """Stands in for a generator of random numbers."""

    def __init__(self, value):
        self.value = value

    def integers(self, low, high, size):
        return np.full(size, self.value)


def test_over_the_edges_of_a_cube():
    # The shortest way between opposite corners of two squares in a row.
    vertices = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    _, faces = zoo.cube()
    tables = tables_of(vertices, faces)
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(50):
        other = tables.copy()
        scramble(other, 10, rng, 1e-2)
        edges = all_edges(other)
        paths = drawn(other, tables, edges)
        assert paths.unresolved.size == 0 and mismatch(paths) < 1e-13
        assert paths.lengths_on(vertices) == pytest.approx(paths.lengths, rel=1e-12)
        for e in np.flatnonzero(np.abs(paths.lengths - 5**0.5) < 1e-9):
            i, j = paths.point_offsets[e : e + 2]
            points = paths.points(vertices)[i:j]
            assert np.abs(points[0] - points[-1]).sum() == pytest.approx(3)
            # Half-way up an edge of the cube, and over the diagonals of the squares.
            on_edge = ((points == 0) | (points == 1)).sum(axis=1) == 2
            assert points[on_edge] == pytest.approx(
                np.where((points[on_edge] % 1) == 0, points[on_edge], 0.5)
            )
            assert on_edge.sum() == 1
            found += 1
    assert found > 5


@given(st.integers(4, 16), st.integers(0, 60), st.integers(0, 10**6), st.sampled_from([1.0, 30.0]))
def test_edges_of_the_input_on_the_polyhedron(n, m, seed, length):
    body, hull = zoo.random_hull(n, seed)
    vertices, faces, flat = sprinkled(body * [length, 1, 1], hull, m, seed)
    tables = tables_of(vertices, faces)
    core, removal = remove_flat_vertices(tables, flat)
    core, bent = polyhedron(core, vertices[~flat])
    restored = insert_vertices(core, removal, bent)
    paths = edge_paths(tables, restored.tables, restored.polygons, all_edges(tables))
    assert mismatch(paths) < 1e-9
    # All of them are chords of the body: the original triangles lie in its faces.
    starts = paths.point_offsets
    points = paths.points(vertices)
    for (i, j), (a, b) in zip(pairwise(starts), paths.ends, strict=True):
        chord = vertices[b] - vertices[a]
        part = (points[i:j] - vertices[a]) @ chord / (chord @ chord)
        assert np.abs(points[i:j] - vertices[a] - part[:, None] * chord).max() < 1e-9 * length
        assert (np.diff(part) > -1e-9).all()
    straight = distances(tables, vertices)[all_edges(tables)]
    assert paths.lengths_on(vertices) == pytest.approx(straight, rel=1e-9)


@pytest.mark.parametrize("curvature", [-1.0, 1.0, -1e-14])
@pytest.mark.parametrize("size", [1e-2, 1.0, 3.0])
@given(st.integers(4, 16), st.integers(0, 40), st.integers(0, 10**6), st.sampled_from([1.0, 30.0]))
def test_edges_of_the_input_in_hyperbolic_and_spherical_space(curvature, size, n, m, seed, aspect):
    x, faces, flat = curved.body(n, seed, curvature, size, m, aspect)
    tables = curved.tables_in(x, faces, curvature)
    core, removal = remove_flat_vertices(tables, flat)
    core, bent = curved.polyhedron_in(core, x[~flat])
    restored = insert_vertices(core, removal, bent)
    paths = edge_paths(tables, restored.tables, restored.polygons, all_edges(tables))
    assert mismatch(paths) < 1e-9
    straight = curved.distances_in(tables, x)[all_edges(tables)]
    assert paths.lengths_on(x) == pytest.approx(straight, abs=1e-9 * size)
    assert ((paths.parameters >= 0) & (paths.parameters <= 1)).all()


@given(st.integers(0, 10**6), st.sampled_from([1.0, 10.0]))
def test_there_and_back_again(seed, length):
    # Whichever of two triangulations is drawn on the other, their edges cross as often.
    body, faces = zoo.random_hull(12, seed)
    one = tables_of(body * [length, 1, 1], faces)
    other = one.copy()
    scramble(other, 40, np.random.default_rng(seed), 1e-2)
    on_other = drawn(one, other, all_edges(one))
    on_one = drawn(other, one, all_edges(other))
    assert mismatch(on_other) < 1e-10 and mismatch(on_one) < 1e-10
    assert on_one.halfedges.size == on_other.halfedges.size
    assert on_one.lengths_on(body * [length, 1, 1]) == pytest.approx(on_one.lengths, abs=1e-10 * length)


def test_grids_of_many_points_in_line():
    vertices, faces, flat = box(12)
    tables = tables_of(vertices, faces)
    shuffled = tables.copy()
    scramble(shuffled, 10 * len(vertices), np.random.default_rng(0))
    core, removal = remove_flat_vertices(shuffled, flat)
    core, bent = polyhedron(core, vertices[~flat])
    restored = insert_vertices(core, removal, bent)
    final = restored.tables
    for original in (tables, shuffled):
        paths = edge_paths(original, final, restored.polygons, all_edges(original))
        assert mismatch(paths) < 1e-10
        assert paths.lengths_on(vertices) == pytest.approx(paths.lengths, abs=1e-11)
        assert ((paths.parameters >= 0) & (paths.parameters <= 1)).all()
        s = paths.parameters[:, None]
        a, b = final.corners[paths.halfedges], final.corners[final.twins[paths.halfedges]]
        starts = paths.point_offsets
        inner = np.delete(np.arange(starts[-1]), np.concatenate([starts[:-1], starts[1:] - 1]))
        assert paths.points(vertices)[inner] == pytest.approx((1 - s) * vertices[a] + s * vertices[b])


def test_a_path_that_goes_astray_is_lost():
    vertices, faces = zoo.random_hull(20, 4)
    tables = tables_of(vertices, faces)
    v = 7
    turned = tables.directions + np.where(tables.corners == v, 0.1, 0.0)
    elsewhere = HalfEdges(tables.corners, tables.twins, tables.lengths, turned)
    edges = all_edges(tables)
    paths = drawn(elsewhere, tables, edges)
    assert np.array_equal(paths.unresolved, np.flatnonzero(tables.corners[edges] == v))
    assert paths.unresolved.size > 0
    assert np.isnan(paths.distances).sum() == paths.unresolved.size
    # It is drawn with its ends alone.
    e = paths.unresolved[0]
    assert paths.offsets[e] == paths.offsets[e + 1]
    assert np.array_equal(paths.points(vertices)[paths.point_offsets[e]], vertices[v])


def test_an_edge_without_a_direction_is_lost():
    tables = tables_of(*zoo.tetrahedron())
    edges = all_edges(tables)
    directions = tables.directions.copy()
    directions[edges[3]] = np.nan
    paths = drawn(tables._replace(directions=directions), tables, edges)
    assert paths.unresolved.tolist() == [3]


def test_distances_are_those_of_the_final_metric():
    vertices, faces = zoo.random_hull(20, 4)
    tables = tables_of(vertices, faces)
    metric = checked(tables)
    longer = HalfEdges(tables.corners, tables.twins, tables.lengths * (1 + 1e-8), tables.directions)
    paths = drawn(tables, longer, all_edges(tables))
    assert mismatch(paths) == pytest.approx(1e-8 * tables.lengths.max() / metric.mean_length, rel=1e-6)
