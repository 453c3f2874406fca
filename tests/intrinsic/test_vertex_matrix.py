"""Matrices on the vertices of triangles."""

import numpy as np
from scipy.sparse import coo_array

import zoo
from isoembed import GluedMetric, PolyhedralMetric
from isoembed.intrinsic.vertex_matrix import vertex_matrix


def summed(corners, twins, values, diagonal):
    n = len(diagonal)
    rows, columns = np.append(corners, np.arange(n)), np.append(corners[twins], np.arange(n))
    return coo_array((np.append(values, diagonal), (rows, columns)), shape=(n, n)).toarray()


def check(corners, twins, values, diagonal):
    found = vertex_matrix(corners, twins, values, diagonal)
    np.testing.assert_allclose(found.toarray(), summed(corners, twins, values, diagonal), atol=1e-14)
    assert found.has_canonical_format
    assert found.indices.dtype == found.indptr.dtype == np.int32
    return found


def test_entries_of_a_simplicial_surface():
    vertices, faces = zoo.random_hull(60, 1)
    tables = GluedMetric.of(PolyhedralMetric.from_mesh(vertices, faces)).half_edges()
    rng = np.random.default_rng(0)
    by_edge = rng.normal(size=tables.corners.size)
    values = by_edge + by_edge[tables.twins]
    found = check(tables.corners, tables.twins, values, rng.normal(size=60))
    assert found.nnz == 60 + tables.corners.size


def test_loops_and_repeated_edges_are_summed():
    # A triangle folded shut along two of its sides, and another that closes the loop.
    corners, twins = np.array([0, 0, 1, 0, 0, 2]), np.array([3, 2, 1, 0, 5, 4])
    values = np.array([1.0, 2.0, 2.0, 1.0, 3.0, 3.0])
    check(corners, twins, values, np.array([10.0, 20.0, 30.0]))
    doubled = np.array([0, 1, 2, 0, 2, 1]), np.array([5, 4, 3, 2, 1, 0])
    check(*doubled, np.array([1.0, 2.0, 3.0, 3.0, 2.0, 1.0]), np.zeros(3))


def test_what_vanishes_is_in_the_pattern():
    vertices, faces = zoo.random_hull(20, 0)
    tables = GluedMetric.of(PolyhedralMetric.from_mesh(vertices, faces)).half_edges()
    found = vertex_matrix(tables.corners, tables.twins, np.zeros(tables.corners.size), np.zeros(20))
    assert found.nnz == 20 + tables.corners.size
