"""Coordinates for the vertices of a graph: hop distances, counted in edges, to three pairs of far ones."""

from __future__ import annotations

import numpy as np
from numba import njit

from isoembed.arrays import Floats, Indices
from isoembed.linalg.separator import DISSECTION, Graph


def hop_coordinates(graph: Graph) -> Floats:
    """Differences of hop distances to three pairs of far vertices, chosen across one another, smoothed.

    Parameters
    ----------
    graph : Graph
        Connected, of n vertices.

    Returns
    -------
    ndarray, shape (n, 3)
    """
    n = graph.indptr.size - 1
    position = np.zeros((n, 3))
    aside = np.zeros(n, dtype=np.int64)  # from the middle of the axes so far
    near = breadth_first(graph, 0)[1]  # least distance to the ends chosen so far
    for c in range(3):
        # A point far from the earlier ends and midway between them, and the one opposite to it: a step along
        # an earlier axis changes that coordinate by 2 but a distance by 1 only.
        start = int(np.argmax(near - aside))
        from_start = breadth_first(graph, start)[1]
        away = np.abs(position[:, :c] - position[start, :c]).sum(axis=1)
        from_end = breadth_first(graph, int(np.argmax(from_start - away)))[1]
        position[:, c] = from_start - from_end
        aside += np.abs(from_start - from_end)
        nearest = np.minimum(from_start, from_end)
        near = nearest if c == 0 else np.minimum(near, nearest)
    for _ in range(DISSECTION.smoothings):
        position = _smoothed(graph, position)
    return position


@njit(cache=True)
def breadth_first(graph: Graph, start: int) -> tuple[Indices, Indices]:
    """The vertices in order of their distance from one, and their distances, -1 where there is no path.

    Returns
    -------
    order : ndarray of int64
        Only the vertices that a path leads to.
    hops : ndarray of int64, shape (n,)
        Edges on a shortest path.
    """
    n = graph.indptr.size - 1
    order, hops = np.empty(n, dtype=np.int64), np.full(n, -1)
    order[0], hops[start] = start, 0
    head, tail = 0, 1
    while head < tail:
        v = order[head]
        head += 1
        for p in range(graph.indptr[v], graph.indptr[v + 1]):
            u = graph.indices[p]
            if hops[u] < 0:
                hops[u] = hops[v] + 1
                order[tail] = u
                tail += 1
    return order[:tail], hops


@njit(cache=True)
def _smoothed(graph: Graph, position: Floats) -> Floats:
    """Averages over every vertex and its neighbors."""
    average = position.copy()
    for v in range(position.shape[0]):
        for p in range(graph.indptr[v], graph.indptr[v + 1]):
            for c in range(3):
                average[v, c] += position[graph.indices[p], c]
        for c in range(3):
            average[v, c] /= 1 + graph.indptr[v + 1] - graph.indptr[v]
    return average
