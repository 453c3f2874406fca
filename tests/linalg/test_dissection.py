"""Nested dissection: permutations, separators that separate, and how the fill grows."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial import ConvexHull

from isoembed.linalg import dissect
from isoembed.linalg.bisection import lift_ends
from isoembed.threads import reserve_threads


def hull_edges(points):
    faces = ConvexHull(points).simplices.astype(np.int64)
    return np.unique(
        np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0
    )


def random_sphere(n, seed=0):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, None]


def fibonacci_sphere(n):
    k = np.arange(n) + 0.5
    z, angle = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    return np.stack((np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z), axis=1)


def adjacency(n, edges):
    half = sp.coo_array((np.ones(len(edges)), edges.T), shape=(n, n))
    return (half + half.T).tocsr()


def line_graph(n, edges):
    """Pattern of J J^T: edges with a common end, and the diagonal."""
    incidence = sp.csr_array(
        (np.ones(edges.size), edges.ravel(), 2 * np.arange(len(edges) + 1)), shape=(len(edges), n)
    )
    return sp.csc_array(incidence @ incidence.T)


def fill(pattern, order=None, ordering="NATURAL"):
    """Entries of L + U in elimination order, by SuperLU, for a diagonally dominant matrix of the pattern."""
    n = pattern.shape[0]
    matrix = sp.csc_array(pattern + sp.diags_array(np.full(n, float(n))))
    if order is not None:
        matrix = sp.csc_array(matrix[order][:, order])
    return splu(
        matrix, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": ordering != "COLAMD"}
    ).nnz


def is_permutation(order, n):
    return np.array_equal(np.sort(order), np.arange(n))


@settings(deadline=None, max_examples=40)
@given(n=st.integers(4, 120), seed=st.integers(0, 10**6))
def test_orders_are_permutations_and_repeatable(n, seed):
    edges = hull_edges(random_sphere(n, seed))
    once, again = (dissect(adjacency(n, edges)) for _ in range(2))
    assert is_permutation(once.vertex_order(), n)
    assert is_permutation(once.edge_order(edges), len(edges))
    assert is_permutation(once.block_order(3), 3 * n)
    assert np.array_equal(once.vertex_order(), again.vertex_order())
    assert np.array_equal(once.edge_order(edges), again.edge_order(edges))


def test_orders_are_the_same_for_any_number_of_threads():
    n = 30_000
    edges = hull_edges(fibonacci_sphere(n))
    found = []
    for count in (1, 2, 3):
        with reserve_threads(count):
            tree = dissect(adjacency(n, edges))
            found.append(np.concatenate([tree.vertex_order(), tree.edge_order(edges)]))
    assert is_permutation(found[0][:n], n)
    np.testing.assert_array_equal(found[1:], found[:1] * 2)


@pytest.mark.parametrize("n", [4, 5, 6, 7])
def test_smallest_meshes(n):
    edges = hull_edges(random_sphere(n))
    tree = dissect(adjacency(n, edges))
    assert is_permutation(tree.vertex_order(), n)
    assert is_permutation(tree.edge_order(edges), len(edges))


def test_a_path_and_a_star_are_graphs_too():
    n = 500
    path = np.stack((np.arange(n - 1), np.arange(1, n)), axis=1)
    star = np.stack((np.zeros(n - 1, dtype=np.int64), np.arange(1, n)), axis=1)
    for edges, most in ((path, 7 * n), (star, n * n // 20)):
        graph = adjacency(n, edges)
        tree = dissect(graph)
        assert is_permutation(tree.edge_order(edges), n - 1)
        assert fill(graph, tree.vertex_order()) < most


def test_blocks_stay_together():
    n = 300
    tree = dissect(adjacency(n, hull_edges(random_sphere(n))))
    blocks = tree.block_order(3).reshape(n, 3)
    assert np.array_equal(blocks // 3, np.repeat(tree.vertex_order()[:, None], 3, axis=1))
    assert np.array_equal(blocks % 3, np.tile(np.arange(3), (n, 1)))


def test_the_result_is_immutable():
    tree = dissect(adjacency(50, hull_edges(random_sphere(50))))
    with pytest.raises(ValueError, match="read-only"):
        tree.vertex_order()[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        tree.cells[0] = 1


def largest_part(graph, removed):
    kept = np.setdiff1d(np.arange(graph.shape[0]), removed)
    return np.bincount(connected_components(graph[kept][:, kept])[1]).max()


@pytest.mark.parametrize("stretch", [(1, 1, 1), (3, 2, 1), (12, 1, 1)])
def test_the_last_vertices_separate_the_rest(stretch):
    n = 4000
    edges = hull_edges(random_sphere(n) * stretch)
    graph = adjacency(n, edges)
    order = dissect(graph).vertex_order()
    # A great circle of a sphere of n vertices is sqrt(pi n) / 1.07 edges long: about as many vertices cut it.
    last = order[-int(2.5 * np.sqrt(n)) :]
    parts = [largest_part(graph, last[-k:]) for k in range(10, len(last), 5)]
    assert min(parts) < 0.65 * n


def test_the_last_edges_separate_the_rest():
    n = 4000
    edges = hull_edges(random_sphere(n))
    order = dissect(adjacency(n, edges)).edge_order(edges)
    most = int(6 * np.sqrt(n))
    parts = []
    for k in range(10, most, 10):
        labels = connected_components(adjacency(n, edges[order[:-k]]))[1]
        parts.append(np.bincount(labels).max())
    assert min(parts) < 0.65 * n


@pytest.mark.parametrize("points", [pytest.param(fibonacci_sphere, marks=pytest.mark.slow), random_sphere])
def test_fill_of_edge_matrices_is_far_below_the_library_orders(points):
    n = 8000
    edges = hull_edges(points(n))
    pattern = line_graph(n, edges)
    ours = fill(pattern, dissect(adjacency(n, edges)).edge_order(edges))
    assert ours < 0.55 * fill(pattern, ordering="COLAMD")
    assert ours < 1.02 * fill(pattern, ordering="MMD_AT_PLUS_A")


@pytest.mark.parametrize("points", [fibonacci_sphere, random_sphere])
def test_fill_of_vertex_matrices_is_far_below_the_library_orders(points):
    n = 8000
    graph = adjacency(n, hull_edges(points(n)))
    ours = fill(graph, dissect(graph).vertex_order())
    assert ours < 0.6 * fill(graph, ordering="COLAMD")
    assert ours < fill(graph, ordering="MMD_AT_PLUS_A")


def test_the_format_of_the_graph_changes_nothing():
    graph = adjacency(500, hull_edges(random_sphere(500)))
    expected = dissect(graph).vertex_order()
    for other in (sp.csc_array(graph), sp.coo_matrix(graph), sp.csc_array(np.pi * graph)):
        assert np.array_equal(dissect(other).vertex_order(), expected)


def test_a_diagonal_changes_little():
    n = 3000
    graph = adjacency(n, hull_edges(random_sphere(n)))
    with_diagonal = dissect(sp.csc_array(graph + sp.identity(n))).vertex_order()
    assert fill(graph, with_diagonal) < 1.05 * fill(graph, dissect(graph).vertex_order())


def test_how_vertices_are_numbered_hardly_matters():
    n = 5000
    edges = hull_edges(fibonacci_sphere(n))
    shuffled = np.random.default_rng(5).permutation(n)[edges]
    entries = []
    for ends in (edges, shuffled):
        graph = adjacency(n, ends)
        entries.append(fill(graph, dissect(graph).vertex_order()))
    assert 0.9 < entries[1] / entries[0] < 1.1


def test_edges_ordered_as_their_vertices_fill_far_more():
    n = 4000
    edges = hull_edges(fibonacci_sphere(n))
    tree, pattern = dissect(adjacency(n, edges)), line_graph(n, edges)
    place = np.argsort(tree.vertex_order())
    inherited = np.lexsort(np.sort(place[edges], axis=1).T)
    assert fill(pattern, tree.edge_order(edges)) < 0.7 * fill(pattern, inherited)


@pytest.mark.parametrize("stretch", [pytest.param((1, 1, 1), marks=pytest.mark.slow), (3, 2, 1)])
def test_fill_grows_like_n_log_n(stretch):
    sizes = np.array([1000, 2000, 4000, 8000, 16000])
    by_edge, by_vertex = [], []
    for n in sizes:
        edges = hull_edges(fibonacci_sphere(n) * stretch)
        graph = adjacency(n, edges)
        tree = dissect(graph)
        by_edge.append(fill(line_graph(n, edges), tree.edge_order(edges)))
        by_vertex.append(fill(graph, tree.vertex_order()))
    for entries in (by_edge, by_vertex):
        exponent = np.polyfit(np.log(sizes), np.log(entries), 1)[0]
        assert 1.0 < exponent < 1.2


def test_a_graph_in_two_pieces_is_refused():
    with pytest.raises(ValueError, match="not connected: no path from vertex 0 to vertex 4"):
        dissect(sp.block_diag([sp.coo_array(np.ones((4, 4))), np.ones((4, 4))]))


def flipped(points, edges, count):
    """The graph with some edges of it replaced by others between their neighbors."""
    graph = adjacency(len(points), edges).tolil()
    for i, j in edges[np.random.default_rng(0).permutation(len(edges))[:count]]:
        common = np.intersect1d(graph.rows[i], graph.rows[j])
        if common.size == 2:
            graph[i, j] = graph[j, i] = 0
            graph[common[0], common[1]] = graph[common[1], common[0]] = 1
    return sp.csc_array(graph)


def test_an_order_is_kept_where_the_graph_is():
    n = 500
    tree = dissect(adjacency(n, hull_edges(fibonacci_sphere(n))))
    fewer = sp.csc_array(adjacency(n, hull_edges(fibonacci_sphere(n))[: 2 * n]))
    assert np.array_equal(tree.order_of(fewer), tree.vertex_order())


@pytest.mark.parametrize("count", [1, 20, 100, 1500])
def test_an_order_is_mended_where_some_edges_are_others(count):
    points = fibonacci_sphere(2000)
    edges = hull_edges(points)
    tree, graph = dissect(adjacency(2000, edges)), flipped(points, edges, count)
    mended = tree.order_of(graph)
    assert is_permutation(mended, 2000)
    own = fill(graph, dissect(graph).vertex_order())
    assert fill(graph, mended) < 1.3 * own
    assert count < 100 or fill(graph, mended) < fill(graph, tree.vertex_order())


def test_edges_join_cells_to_separators_above_them():
    points = fibonacci_sphere(1000)
    edges = hull_edges(points)
    tree, graph = dissect(adjacency(1000, edges)), flipped(points, edges, 300)
    path, depth = (places.copy() for places in tree._separated[1:])
    assert lift_ends(graph.indptr, graph.indices, path, depth) > 0
    assert lift_ends(graph.indptr, graph.indices, path, depth) == 0
