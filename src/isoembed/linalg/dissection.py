"""Nested dissection ordering of a surface mesh.

No library and no positions are needed: the distances, counted in edges, to three pairs of far vertices place
every vertex well enough for cells to be halved near their medians.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.linalg.bisection import bisection_paths, breadth_first, lift_ends, separators, smoothed
from isoembed.linalg.elimination import permuted
from isoembed.linalg.separator import Graph
from isoembed.mesh.triangulation import frozen


@dataclass(frozen=True, eq=False)
class Dissection:
    """Nested dissection of a graph, made by `dissect`.

    Attributes
    ----------
    graph : Graph
        The graph, its vertices numbered anew so that neighbors are near in memory.
    labels : (V,) int64
        The vertex that bears each new number.
    position : (V, 3)
        Coordinates of the vertices in their new order.
    """

    graph: Graph
    labels: Indices
    position: Floats

    def edge_order(self, edges: ArrayLike) -> Indices:
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

    def vertex_order(self) -> Indices:
        """Elimination order of a matrix on the vertices, like a Laplacian: the separators come last."""
        return self._separated[0]

    def order_of(self, adjacency: sp.csc_array) -> Indices:
        """`vertex_order` of another graph on the same vertices, most of whose edges are those of this one.

        Where an edge joins two parts, one of its ends moves into what separates them.  Where that would be
        too many, the graph is dissected anew, in the same coordinates.

        Parameters
        ----------
        adjacency : sparse, (V, V)
            Symmetric, in compressed columns.
        """
        path, depth = (places.copy() for places in self._separated[1:])
        indptr, indices = (
            table.astype(np.int32, copy=False) for table in (adjacency.indptr, adjacency.indices)
        )
        lifted = lift_ends(indptr, indices, path, depth)
        if lifted == 0:
            return self.vertex_order()
        if lifted > 0.03 * path.size:  # moving more vertices costs more than a new dissection
            indptr, indices, _ = permuted(indptr, indices, self.labels, False)
            return frozen(self.labels[separators(Graph(indptr, indices), self.position)[0]])
        deepest = depth.max()
        # Post-order: by the last leaf below, and there the deepest first.
        rank = (((path + 1) << (deepest - depth)) - 1) * (deepest + 1) + deepest - depth
        order = self.vertex_order()
        return frozen(order[np.argsort(rank[order], kind="stable")])

    def block_order(self, k: int) -> Indices:
        """`vertex_order` for k unknowns a vertex, numbered ``k * vertex + component`` and kept together."""
        return (k * self.vertex_order()[:, None] + np.arange(k)).ravel()

    @cached_property
    def cells(self) -> Indices:
        """(V,): the leaf of a balanced binary tree that holds each vertex.

        Its binary digits, the highest first, are the parts taken on the way down from the whole graph, so two
        vertices part where their numbers first differ.
        """
        cells = np.empty_like(self.labels)
        cells[self.labels] = bisection_paths(self.graph, self.position)
        return frozen(cells)

    @cached_property
    def _separated(self) -> tuple[Indices, Indices, Indices]:
        """The order of the vertices, and of each the path and the depth in the tree."""
        order, *places = separators(self.graph, self.position)
        path, depth = np.empty((2, order.size), dtype=np.int64)
        path[self.labels], depth[self.labels] = places
        return frozen(self.labels[order]), frozen(path), frozen(depth)


def dissect(adjacency: sp.sparray | sp.spmatrix) -> Dissection:
    """Nested dissection of a connected graph that is planar or nearly so.

    Every vertex gets three coordinates: differences of its hop distances to two far vertices, smoothed. A
    cell is cut across its longest axis near the median, where that severs few edges. Deterministic.

    Parameters
    ----------
    adjacency : sparse, (V, V)
        Symmetric; its pattern is the graph, with or without a diagonal. Values do not matter.

    Returns
    -------
    Dissection

    Raises
    ------
    ValueError
        If the graph is not connected.
    """
    if adjacency.format == "csc":
        adjacency = adjacency.T  # is itself
    rows = sp.csr_array(adjacency)
    graph = Graph(rows.indptr.astype(np.int32), rows.indices.astype(np.int32))
    n = rows.shape[0]
    labels, hops = breadth_first(graph, 0)
    if labels.size < n:
        lost = int(np.argmin(hops))
        raise ValueError(f"the graph is not connected: no path from vertex 0 to vertex {lost}")
    # Neighbors that are near in memory are read faster.
    indptr, indices, _ = permuted(graph.indptr, graph.indices, labels, False)
    near = Graph(indptr, indices)
    return Dissection(near, labels, _hop_coordinates(near))


def _hop_coordinates(graph: Graph) -> Floats:
    """Coordinates of the vertices of a connected graph, (n, 3).

    Differences of hop distances to three pairs of far vertices, chosen across one another, smoothed.
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
    for _ in range(3):  # the level lines of hop distances are ragged
        position = smoothed(graph, position)
    return position


def _bit_length(x: Indices) -> Indices:
    return np.frexp(x.astype(np.float64))[1].astype(np.int64)


def _last_leaf(cells: Indices, height: Indices) -> Indices:
    """The last leaf under the node `height` levels above each: the place in post-order, but for height."""
    return cells | ((np.int64(1) << height) - 1)
