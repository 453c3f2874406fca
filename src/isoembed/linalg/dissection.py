"""Nested dissection of a surface mesh from hop distances, and the elimination orders that it gives.

No library and no positions are needed: the distances, counted in edges, to three pairs of far vertices place
every vertex well enough for cells to be halved by their medians.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import breadth_first_order

_LEAF = 4
"""Cells are halved until they hold about this many vertices; smaller cells bring no less fill."""

_WINDOW = 0.2
"""A cell may be cut this far from its median, as a fraction of its size, where the cut is shorter."""

_SMOOTHINGS = 10
"""Averages over neighbors before the first cut: hop distances are integers and their level lines ragged."""


@dataclass(frozen=True, eq=False)
class Dissection:
    """A balanced binary tree of cells on the vertices of a graph, made by `dissect`.

    Attributes
    ----------
    adjacency : sparse CSR, (V, V)
        The graph.
    cells : (V,) int64
        The leaf that holds each vertex. Its `depth` binary digits, the highest first, are the halves taken on
        the way down, so two vertices part where their numbers first differ.
    depth : int
        Number of halvings; there are ``2**depth`` leaves.
    """

    adjacency: sp.csr_array
    cells: NDArray[np.int64]
    depth: int

    def edge_order(self, edges: ArrayLike) -> NDArray[np.int64]:
        """Elimination order of a matrix on the edges, like J J^T, where edges with a common end are coupled.

        Parameters
        ----------
        edges : (E, 2) int
            Ends of the edges.

        Returns
        -------
        (E,) int64
            The k-th edge to eliminate is ``perm[k]``. An edge belongs to the node of the tree at which its
            ends part (to their leaf if they never do); children come before parents.
        """
        ends = np.asarray(edges, dtype=np.int64).reshape(-1, 2)
        first, second = self.cells[ends[:, 0]], self.cells[ends[:, 1]]
        height = _bit_length(first ^ second)
        return np.lexsort((np.minimum(first, second), height, _last_leaf(first, height)))

    def vertex_order(self) -> NDArray[np.int64]:
        """Elimination order of a matrix on the vertices, like a Laplacian.

        Returns
        -------
        (V,) int64
            The k-th vertex to eliminate is ``perm[k]``. Both halves of a cell come before the vertices that
            separate them: the ends, on the side with fewer of them, of the edges between the halves.
        """
        return self._vertex_order

    def block_order(self, k: int) -> NDArray[np.int64]:
        """Elimination order of a matrix with k unknowns a vertex, numbered ``k * vertex + component``.

        Returns
        -------
        (k V,) int64
            `vertex_order` with the k unknowns of a vertex kept together.
        """
        return (k * self._vertex_order[:, None] + np.arange(k)).ravel()

    @cached_property
    def _vertex_order(self) -> NDArray[np.int64]:
        ends = _ends(self.adjacency)
        parting = _bit_length(self.cells[ends[:, 0]] ^ self.cells[ends[:, 1]])
        height = np.zeros(self.cells.size, dtype=np.int64)  # of the node that the vertex separates; 0: none
        for level in range(self.depth, 0, -1):
            cut = ends[parting == level]
            cut = cut[(height[cut] == 0).all(axis=1)]  # a larger separator has severed the others
            boundary = np.unique(cut)
            half = self.cells[boundary] >> (level - 1)
            count = np.bincount(half, minlength=1 << (self.depth - level + 1)).reshape(-1, 2)
            fewer = np.stack((count[:, 0] <= count[:, 1], count[:, 0] > count[:, 1]), axis=1).ravel()
            height[boundary[fewer[half]]] = level
        order = np.lexsort((self.cells, height, _last_leaf(self.cells, height)))
        order.flags.writeable = False
        return order


def dissect(adjacency: sp.sparray | sp.spmatrix) -> Dissection:
    """Nested dissection of a connected graph that is planar or nearly so.

    Every vertex gets three coordinates: differences of its hop distances to two far vertices, smoothed. A
    cell is sorted along the coordinate in which it is widest and cut near the median, where that severs
    fewest edges. All cells of a level are cut at once: the cost is that of log V sorts. Deterministic.

    Parameters
    ----------
    adjacency : sparse, (V, V)
        Symmetric; its pattern is the graph. Values do not matter.

    Returns
    -------
    Dissection

    Raises
    ------
    ValueError
        If the graph is not connected.
    """
    graph = sp.csr_array(adjacency, dtype=np.float64, copy=True)
    graph.data[:] = 1.0
    n = graph.shape[0]
    depth = max(0, int(np.ceil(np.log2(n / _LEAF))))
    position = _hop_coordinates(graph)
    share = 1.0 / (1.0 + graph.sum(axis=1))[:, None]
    for _ in range(_SMOOTHINGS):
        position = (position + graph @ position) * share
    rank = np.empty((n, 3), dtype=np.int64)
    np.put_along_axis(rank, np.argsort(position, axis=0, kind="stable"), np.arange(n)[:, None], axis=0)

    ends = _ends(graph)
    cells = np.zeros(n, dtype=np.int64)
    order = np.arange(n)
    for _ in range(depth):
        order, upper = _cut(order, cells, position, rank, ends)
        cells = 2 * cells + upper
        ends = ends[upper[ends[:, 0]] == upper[ends[:, 1]]]
    cells.flags.writeable = False
    return Dissection(graph, cells, depth)


def _cut(
    order: NDArray[np.int64],
    cells: NDArray[np.int64],
    position: NDArray[np.float64],
    rank: NDArray[np.int64],
    ends: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Cut every cell in two.

    Takes the vertices in order of cells, the cell, coordinates and ranks of each, and the edges within cells;
    returns the vertices sorted along the cuts, and (V,) which are in the upper half of their cell.
    """
    n = order.size
    start = np.flatnonzero(np.diff(cells[order], prepend=-1))
    size = np.diff(start, append=n)
    cell = np.repeat(np.arange(size.size), size)
    inside = position[order]
    mean = np.add.reduceat(inside, start) / size[:, None]
    widest = np.add.reduceat((inside - mean[cell]) ** 2, start).argmax(axis=1)
    order = order[np.argsort(cell * n + rank[order, widest[cell]])]

    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    a, b = place[ends].T
    # severed[p]: edges from a place before p to p or beyond
    steps = np.bincount(np.minimum(a, b) + 1, minlength=n + 1) - np.bincount(
        np.maximum(a, b) + 1, minlength=n + 1
    )
    severed = np.cumsum(steps)[:n]
    after = np.arange(n) - start[cell]
    off_median = np.abs(after / size[cell] - 0.5)
    cost = (severed + 1) * (1.0 + off_median)
    cost[(off_median > np.maximum(_WINDOW, 0.5 / size[cell])) | (after == 0)] = np.inf
    cheapest = np.flatnonzero(cost == np.minimum.reduceat(cost, start)[cell])
    split = cheapest[np.searchsorted(cheapest, start)]
    split[size == 1] = n  # a single vertex goes to the lower half
    upper = np.empty(n, dtype=np.bool_)
    upper[order] = np.arange(n) >= split[cell]
    return order, upper


def _hop_coordinates(graph: sp.csr_array) -> NDArray[np.float64]:
    """Differences of hop distances to three pairs of far vertices, chosen across one another. (V, 3)."""
    position = np.zeros((graph.shape[0], 3))
    near = _hops(graph, 0)  # least distance to the ends chosen so far
    for c in range(3):
        # A point far from the earlier ends and midway between them, and the one opposite to it: a step along
        # an earlier axis changes that coordinate by 2 but a distance by 1 only.
        start = int(np.argmax(near - np.abs(position[:, :c]).sum(axis=1)))
        from_start = _hops(graph, start)
        aside = np.abs(position[:, :c] - position[start, :c]).sum(axis=1)
        from_end = _hops(graph, int(np.argmax(from_start - aside)))
        position[:, c] = from_start - from_end
        nearest = np.minimum(from_start, from_end)
        near = nearest if c == 0 else np.minimum(near, nearest)
    return position


def _hops(graph: sp.csr_array, start: int) -> NDArray[np.int64]:
    """Number of edges on a shortest path from one vertex to each. (V,)."""
    n = graph.shape[0]
    order, parent = breadth_first_order(graph, start)
    if order.size < n:
        lost = np.setdiff1d(np.arange(n), order)[0]
        raise ValueError(f"the graph is not connected: no path from vertex {start} to vertex {lost}")
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    # Vertices come in order of distance, and the parents of one layer lie in the layer before it.
    parents = place[parent[order[1:]]]
    layers = [0, 1]
    while layers[-1] < n:
        layers.append(1 + int(np.searchsorted(parents, layers[-1])))
    hops = np.empty(n, dtype=np.int64)
    hops[order] = np.repeat(np.arange(len(layers) - 1), np.diff(layers))
    return hops


def _ends(graph: sp.csr_array) -> NDArray[np.int64]:
    """Edges of the graph, each once. (E, 2)."""
    return np.stack(sp.triu(graph, 1, format="coo").coords, axis=1).astype(np.int64)


def _bit_length(x: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.frexp(x.astype(np.float64))[1].astype(np.int64)


def _last_leaf(cells: NDArray[np.int64], height: NDArray[np.int64]) -> NDArray[np.int64]:
    """The last leaf under the node `height` levels above each: the place in post-order, but for height."""
    return cells | ((np.int64(1) << height) - 1)
