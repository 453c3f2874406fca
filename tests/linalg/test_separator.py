"""Separators: they separate, and no smaller set of the band does, by an independent maximal flow."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import maximum_flow
from scipy.spatial import Delaunay

from isoembed.linalg.separator import LARGEST_SIDE, SEPARATOR, Graph, separate


def planar_graph(n, seed):
    """A Delaunay triangulation of random points in the unit square."""
    points = np.random.default_rng(seed).random((n, 2))
    indptr, indices = Delaunay(points).vertex_neighbor_vertices
    return points, Graph(indptr.astype(np.int32), indices.astype(np.int32))


def severed(graph, cell, numbers):
    """Whether no edge joins the vertices of two numbers."""
    rows = np.repeat(np.arange(cell.size), np.diff(graph.indptr))
    return not ((cell[rows] == numbers[0]) & (cell[graph.indices] == numbers[1])).any()


def layers(graph, cell, width):
    """Hops from the ends of severed edges, and -1 beyond the band."""
    n = cell.size
    rows = np.repeat(np.arange(n), np.diff(graph.indptr))
    layer = np.full(n, -1)
    layer[rows[cell[rows] != cell[graph.indices]]] = 0
    for k in range(width):
        near = np.unique(graph.indices[layer[rows] == k])
        layer[near[layer[near] < 0]] = k + 1
    return layer


def least_separator(graph, cell, width):
    """The size of the smallest separator in the band: a flow with every vertex split in two arcs."""
    n = cell.size
    layer = layers(graph, cell, width)
    band = np.flatnonzero(layer >= 0)
    rows = np.repeat(np.arange(n), np.diff(graph.indptr))
    inner = (layer[rows] >= 0) & (layer[graph.indices] >= 0)
    outer = np.flatnonzero(layer == width)
    sources, sinks = outer[cell[outer] == 0], outer[cell[outer] == 1]
    arcs = np.concatenate(
        [
            np.stack([2 * band, 2 * band + 1]),
            np.stack([2 * rows[inner] + 1, 2 * graph.indices[inner]]),
            np.stack([np.full(sources.size, 2 * n), 2 * sources]),
            np.stack([2 * sinks + 1, np.full(sinks.size, 2 * n + 1)]),
        ],
        axis=1,
    )
    capacity = np.where(np.arange(arcs.shape[1]) < band.size, 1, n).astype(np.int32)
    network = sp.csr_array((capacity, arcs.astype(np.int32)), shape=(2 * n + 2, 2 * n + 2))
    return maximum_flow(network, 2 * n, 2 * n + 1).flow_value


@settings(deadline=None, max_examples=60)
@given(n=st.integers(40, 400), seed=st.integers(0, 10**6), width=st.integers(0, 4))
def test_separators_separate_and_are_the_smallest_of_their_band(n, seed, width):
    points, graph = planar_graph(n, seed)
    cut = (points[:, 0] > 0.5).astype(np.int64)
    cell = cut.copy()
    size = separate(graph, np.arange(n), cell, width)
    assert size == (cell == SEPARATOR).sum()
    assert severed(graph, cell, (0, 1))
    best = [least_separator(graph, cut, w) for w in (width, 0)]
    # A band that leaves one side nearly everything is given up for the ends of the severed edges.
    assert size in best
    if size != best[0]:
        assert width > 0
    if size < best[1]:
        assert max((cell == 0).sum(), (cell == 1).sum()) <= LARGEST_SIDE * n
    beyond = layers(graph, cut, width) < 0
    assert np.array_equal(cell[beyond], cut[beyond])


def test_other_cells_are_left_alone():
    n = 300
    points, graph = planar_graph(n, 1)
    left = np.flatnonzero(points[:, 0] < 0.5)
    cell = np.full(n, 8)
    cell[left] = 4 + (points[left, 1] > 0.4)
    before = cell.copy()
    separate(graph, left, cell, 2)
    others = np.setdiff1d(np.arange(n), left)
    assert np.array_equal(cell[others], before[others])
    assert set(cell[left]) == {4, 5, SEPARATOR}
    assert severed(graph, cell, (4, 5))


def test_a_wide_band_straightens_a_ragged_cut():
    n = 3000
    points, graph = planar_graph(n, 2)
    ragged = points[:, 0] + 0.04 * np.sin(60 * points[:, 1]) > 0.5
    sizes = []
    for width in (0, 4):
        cell = ragged.astype(np.int64)
        sizes.append(separate(graph, np.arange(n), cell, width))
    assert sizes[1] < 0.7 * sizes[0]


def test_a_cut_between_two_pieces_needs_no_separator():
    edges = sp.block_diag([sp.coo_array(np.ones((5, 5))), np.ones((4, 4))], format="csr")
    graph = Graph(edges.indptr.astype(np.int32), edges.indices.astype(np.int32))
    cell = np.repeat(np.array([0, 1]), [5, 4])
    assert separate(graph, np.arange(9), cell, 3) == 0
    assert np.array_equal(cell, np.repeat([0, 1], [5, 4]))


@pytest.mark.parametrize("n", [5, 6, 9])
def test_in_a_complete_graph_one_side_is_the_separator(n):
    graph = Graph(np.arange(0, n * n + 1, n, dtype=np.int32), np.tile(np.arange(n, dtype=np.int32), n))
    cell = (np.arange(n) < n // 2).astype(np.int64)
    assert separate(graph, np.arange(n), cell, 1) == n // 2
