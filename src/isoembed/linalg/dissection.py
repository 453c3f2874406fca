"""Nested dissection of a surface mesh from hop distances, and the elimination orders that it gives.

No library and no positions are needed: the distances, counted in edges, to three pairs of far vertices place
every vertex well enough for cells to be halved near their medians.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.linalg.bisection import bisection_paths, separator_order
from isoembed.linalg.elimination import permuted
from isoembed.linalg.graph_coordinates import breadth_first, hop_coordinates
from isoembed.linalg.separator import Graph


@dataclass(frozen=True, eq=False)
class Dissection:
    """Ways to take a graph apart, made by `dissect`.

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
        """Elimination order of a matrix on the vertices, like a Laplacian.

        Returns
        -------
        (V,) int64
            The k-th vertex to eliminate is ``perm[k]``. Both halves of a cell come before the vertices that
            separate them.
        """
        return self._vertex_order

    def block_order(self, k: int) -> Indices:
        """Elimination order of a matrix with k unknowns a vertex, numbered ``k * vertex + component``.

        Returns
        -------
        (k V,) int64
            `vertex_order` with the k unknowns of a vertex kept together.
        """
        return (k * self._vertex_order[:, None] + np.arange(k)).ravel()

    @cached_property
    def cells(self) -> Indices:
        """(V,): the leaf of a balanced binary tree that holds each vertex.

        Its binary digits, the highest first, are the parts taken on the way down from the whole graph, so two
        vertices part where their numbers first differ.
        """
        cells = np.empty_like(self.labels)
        cells[self.labels] = bisection_paths(self.graph, self.position)
        cells.flags.writeable = False
        return cells

    @cached_property
    def _vertex_order(self) -> Indices:
        order = self.labels[separator_order(self.graph, self.position)]
        order.flags.writeable = False
        return order


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
    return Dissection(near, labels, hop_coordinates(near))


def _bit_length(x: Indices) -> Indices:
    return np.frexp(x.astype(np.float64))[1].astype(np.int64)


def _last_leaf(cells: Indices, height: Indices) -> Indices:
    """The last leaf under the node `height` levels above each: the place in post-order, but for height."""
    return cells | ((np.int64(1) << height) - 1)
