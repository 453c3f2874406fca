"""Edges with the same two ends are flipped away."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.multi_edges import remove_multi_edges, repeated
from isoembed.mesh.triangulation import Triangulation
from scrambling import scramble
from sprinkled import checked, tables_of


def twice(points, faces):
    """A plane triangulation glued to its mirror image, and the half-edges along which it is."""
    faces = np.concatenate([faces, np.asarray(faces)[:, ::-1]])
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    sheet = np.repeat([0, 1], start.size // 2)
    number = {key: h for h, key in enumerate(zip(start.tolist(), end.tolist(), sheet.tolist(), strict=True))}
    glued, kept = [], []
    for a, b, side in number:
        kept.append((b, a, side) not in number)
        glued.append(number[(b, a, 1 - side) if kept[-1] else (b, a, side)])
    lengths = np.linalg.norm(points[start] - points[end], axis=1).reshape(-1, 3)
    return HalfEdges.of(faces, np.array(glued), lengths), np.array(kept)


def convex(n, seed, length):
    angles = 2 * np.pi * (np.arange(n) + np.random.default_rng(seed).uniform(0, 0.9, n)) / n
    return np.column_stack([length * np.cos(angles), np.sin(angles)])


@given(st.integers(4, 30), st.integers(0, 10**6), st.sampled_from([1.0, 5.0]))
def test_sheets_of_a_polygon_get_different_diagonals(n, seed, length):
    tables, kept = twice(convex(n, seed, length), triangulated(n, seed))
    assert repeated(tables).size == 2 * (n - 3)
    before = checked(tables).deficits
    outline = ends(tables, kept)
    remove_multi_edges(tables, kept)
    assert repeated(tables).size == 0
    Triangulation(tables.faces)
    assert checked(tables).deficits == pytest.approx(before, abs=1e-9)
    assert ends(tables, kept) == outline


def triangulated(n, seed):
    """A random triangulation of a convex n-gon."""
    rng = np.random.default_rng(seed)
    rest, faces = list(range(n)), []
    while len(rest) > 2:
        k = int(rng.integers(len(rest)))
        faces.append((rest[k - 1], rest[k], rest[(k + 1) % len(rest)]))
        del rest[k]
    return faces


def ends(tables, kept):
    return sorted(zip(tables.corners[kept], tables.corners[tables.twins[kept]], strict=True))


def test_nothing_is_done_to_a_simplicial_complex():
    tables = tables_of(*zoo.random_hull(30, 1))
    before = tables.copy()
    remove_multi_edges(tables, np.zeros(tables.corners.size, dtype=bool))
    assert np.array_equal(tables.corners, before.corners)


def test_loops_and_double_edges_of_random_triangles():
    body, faces = zoo.random_hull(8, 3)
    tables = tables_of(body * [1, 1, 5], faces)
    rng = np.random.default_rng(3)
    nothing = np.zeros(tables.corners.size, dtype=bool)
    loops = mended = 0
    for _ in range(100):
        scramble(tables, 20, rng, 1e-2)
        before, t = repeated(tables).size, tables.copy()
        remove_multi_edges(t, nothing)
        assert repeated(t).size <= before
        assert checked(t).deficits == pytest.approx(checked(tables).deficits, abs=1e-6)
        loops += (tables.corners == tables.corners[tables.twins]).any()
        mended += before > 0 and repeated(t).size == 0
    assert loops > 10 and mended > 30


def test_of_a_triangle_covered_twice_nothing_can_be_flipped():
    tables, _ = twice(np.array([[0.0, 0], [1, 0], [0, 1]]), [(0, 1, 2)])
    assert repeated(tables).size == 0
    # A side with a vertex on it: both sheets have the same only diagonal.
    tables, kept = twice(np.array([[0.0, 0], [1, 0], [2, 0], [0, 1]]), [(0, 1, 3), (1, 2, 3)])
    remove_multi_edges(tables, kept)
    assert repeated(tables).size == 2
