"""Well-spread coarse vertices and their Voronoi cells on a triangulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.interpolation_loops import chosen_centers
from isoembed.surface.local_fit import edge_lengths_about
from isoembed.surface.measures import edge_lengths
from isoembed.surface.spatial_order import spatial_order


@dataclass(frozen=True, eq=False)
class VertexCells:
    """Coarse vertices and their cells.

    Attributes
    ----------
    vertices : ndarray of int, shape (C,)
        Coarse vertices.
    of_vertex : ndarray of int, shape (V,)
        Cell of each vertex: index of the nearest coarse vertex along the edges.
    """

    vertices: Indices
    of_vertex: Indices

    @classmethod
    def of(cls, triangulation: Triangulation, lengths: Floats, convex: Floats, count: int) -> VertexCells:
        """Choose well-spread vertices, denser where edges are shorter or charts distorted.

        Parameters
        ----------
        triangulation : Triangulation
        lengths : ndarray, shape (E,)
            Edge lengths.
        convex : ndarray, shape (V, 3)
            Surface with other edge lengths, whose charts will be used.
        count : int
            Approximate number of coarse vertices.
        """
        a, b = triangulation.edges.T
        n = triangulation.n_vertices
        units = edge_lengths_about(triangulation, lengths)
        stretch = np.log(edge_lengths_about(triangulation, edge_lengths(triangulation.edges, convex)) / units)
        # smaller cells where charts are distorted
        grading = 1 + 12.6 * np.sqrt(n / count) * _changes(triangulation, stretch)
        hops = lengths / np.sqrt(units[a] * units[b]) * (grading[a] + grading[b]) / 2
        graph = csr_array((np.tile(hops, 2), (np.r_[a, b], np.r_[b, a])), shape=(n, n))
        order = np.random.default_rng(0).permutation(n)
        radius = 0.82 * np.sqrt(n / count)  # chooses about the wanted number
        radius *= np.sqrt(
            len(chosen_centers(graph.indptr, graph.indices, graph.data, order, radius)[0]) / count
        )
        chosen, cell = chosen_centers(graph.indptr, graph.indices, graph.data, order, radius)
        near = spatial_order(convex[chosen])  # neighbors are close in memory
        return cls(chosen[near], np.argsort(near)[cell])

    def triangulation(self, convex: Floats) -> Triangulation | None:
        """Convex hull of the coarse vertices on a convex surface; None if some are not its vertices."""
        from scipy.spatial import ConvexHull, QhullError  # slow to import, rarely needed

        x = convex[self.vertices] - convex.mean(axis=0)
        try:
            hull = ConvexHull(x)
        except QhullError:  # it is flat
            return None
        if len(hull.vertices) < len(x):
            return None
        faces = hull.simplices.astype(np.int64)
        inward = np.linalg.det(x[faces]) < 0
        faces[inward] = faces[inward][:, ::-1]
        return Triangulation(faces)


def _changes(triangulation: Triangulation, values: Floats) -> Floats:
    """Largest differences of smoothed values between a vertex and its neighbors, smoothed, (V,)."""
    adjacency, a, b = triangulation.adjacency, *triangulation.edges.T
    for _ in range(10):  # the logarithm of the stretch is smoothed
        values = (adjacency @ values + values) / (triangulation.degrees + 1)
    changes = np.zeros(len(values))
    for end in (a, b):
        np.maximum.at(changes, end, np.abs(values[a] - values[b]))
    for _ in range(3):  # its change spreads to the neighbors
        changes = (adjacency @ changes + changes) / (triangulation.degrees + 1)
    return cast(Floats, changes)
