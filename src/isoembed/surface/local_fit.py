"""Residuals of local polynomial fits to the neighbors of each vertex.

The polynomial is fitted by weighted least squares in a chart, which maps the neighbors to the plane and the
vertex itself to the origin.  Its value at the vertex is its constant term, and the neighbors' weights in that
term are proportional to the constant column of the fit after projecting out all other monomials.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from isoembed.arrays import Floats, Indices, Mask
from isoembed.linalg.elimination import permuted
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface.fit_loops import fit_constants, rings
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.normal_fits import TWO_RINGS, normal_weights

HUB_DEGREE = 32  # neighbors of a vertex of higher degree need not be near each other


Graph = tuple[NDArray[Any], NDArray[Any]]  # neighbors of vertex i: indices[indptr[i]:indptr[i + 1]]


def neighborhoods(graph: Graph, minimum: int = TWO_RINGS, vertices: range | None = None) -> Graph:
    """Vertices within two edges of each vertex, or within three if these are too few.

    Paths do not lead through vertices with more than 32 edges, so that the total size of all neighborhoods is
    within a fixed multiple of the triangulation's size.

    Parameters
    ----------
    graph : (indptr, indices)
        Adjacency graph of a triangulation.
    minimum : int
        Neighborhoods of fewer vertices are extended by a third ring.
    vertices : range, optional
        The n consecutive vertices whose neighborhoods are returned; by default all V.

    Returns
    -------
    (indptr, indices)
        Neighbors of the n vertices, nearest rings first, without the vertex itself.
    """
    chosen = range(len(graph[0]) - 1) if vertices is None else vertices
    indptr, indices = (table.astype(np.int32, copy=False) for table in graph)
    return rings(indptr, indices, minimum, chosen.start, chosen.stop)


class Surroundings(NamedTuple):
    """Surface with the data for charts around its vertices.

    Attributes
    ----------
    graph : (indptr, indices)
        Adjacency graph.
    vertices, normals : ndarray, shape (V, 3)
    units : ndarray, shape (V,)
        Mean edge length at each vertex.
    heights : ndarray, shape (V,)
        `Space.heights` of the vertices.
    curvature : float
        Curvature of space.
    """

    graph: Graph
    vertices: Floats
    normals: Floats
    units: Floats
    heights: Floats
    curvature: float

    @classmethod
    def of(cls, triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Surroundings:
        """Surroundings of the vertices, (V, 3)."""
        adjacency, edges = triangulation.adjacency, triangulation.edges
        normals = vertex_normals(triangulation.faces, to_model(space, vertices, "conformal"))
        lengths = edge_lengths(edges, vertices) if space.is_euclidean else space.distances(*vertices[edges.T])
        units = edge_lengths_about(triangulation, lengths)
        heights = space.heights(vertices)
        graph = adjacency.indptr.astype(np.int32, copy=False), adjacency.indices.astype(np.int32, copy=False)
        return cls(graph, vertices, normals, units, heights, space.curvature)

    def in_order(self, order: Indices) -> Surroundings:
        """Surroundings with renumbered vertices."""
        indptr, indices, _ = permuted(*self.graph, order, False)
        tables = (self.vertices[order], self.normals[order], self.units[order], self.heights[order])
        return Surroundings((indptr, indices), *tables, self.curvature)

    def neighborhoods(self, minimum: int, at_once: int) -> Iterator[tuple[int, Graph]]:
        """The `neighborhoods` of all vertices in chunks, each with the index of its first vertex."""
        n = len(self.vertices)
        for first in range(0, n, at_once):
            yield first, neighborhoods(self.graph, minimum, range(first, min(first + at_once, n)))


def edge_lengths_about(triangulation: Triangulation, lengths: Floats) -> Floats:
    """Mean length of the edges at each vertex, (V,); 1 if it is zero, where there is no normal either."""
    means = sums_at_ends(triangulation, lengths) / triangulation.degrees
    return np.where(means > 0, means, 1.0)


def sums_at_ends(triangulation: Triangulation, values: Floats | Mask) -> Floats:
    """Sum of the edge values at each vertex, (V,)."""
    return cast(Floats, np.bincount(triangulation.edges.ravel(), np.repeat(values, 2)))


@dataclass(frozen=True)
class FitResiduals:
    """``I - fit`` at some vertices: differences of values from a fit to their neighbors' values.

    The fit is the least-squares polynomial for the neighbors' values with the weights ``1 / (1/2 + |p|^2)``,
    evaluated at the vertex, which is excluded from the fit.  Its degree is reduced if there are too few
    neighbors (fewer than 24 for a quintic, 18, 13, 9, 6 for lower degrees), or if their positions leave the
    value at the origin undetermined (all on one side, or on a conic through it).

    Attributes
    ----------
    first : int
        First of the n consecutive vertices.
    indptr, indices : ndarray of int
        Their `neighborhoods`.
    weights : ndarray, shape (nnz,)
        Weights of the neighbors in the fitted values.
    """

    first: int
    indptr: Indices
    indices: Indices
    weights: Floats

    @classmethod
    def of(cls, first: int, neighborhoods: Graph, charts: Floats, degree: int = 3) -> FitResiduals:
        """Fit polynomials.

        Parameters
        ----------
        first : int
            First of the n vertices.
        neighborhoods : (indptr, indices)
            Neighborhoods of these vertices, as from `neighborhoods`.
        charts : ndarray, shape (nnz, 2)
            Coordinates p of each neighbor in the plane, with the vertex at the origin, in units of the mean
            edge length about the vertex.
        degree : int
            Degree of the polynomials.
        """
        indptr, indices = neighborhoods
        weights = np.empty(len(charts))
        fitted = normal_weights(indptr, charts, degree, weights)
        fit_constants(np.flatnonzero(~fitted), indptr, charts, degree, weights)
        return cls(first, indptr, indices, weights)

    def __matmul__(self, values: Floats) -> Floats:
        """Residuals (n, 3) of values (V, 3); zero for polynomials in a vertex's chart."""
        n = len(self.indptr) - 1
        return cast(Floats, values[self.first : self.first + n] - self._fit(len(values)) @ values)

    def matrix(self, size: int) -> csr_array:
        """Rows of these vertices as a matrix (n, V), given V; each row sums to zero."""
        n = len(self.indptr) - 1
        return csr_array(eye_array(n, size, k=self.first, format="csr") - self._fit(size))

    def _fit(self, size: int) -> csr_array:
        return csr_array((self.weights, self.indices, self.indptr), shape=(len(self.indptr) - 1, size))
