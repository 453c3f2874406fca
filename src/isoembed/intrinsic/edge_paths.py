"""Common subdivision: edges of one triangulation as straight paths across the triangles of another."""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.chart import distances
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.path_loops import cross_all, follow, set_out
from isoembed.intrinsic.polygons import Polygons
from isoembed.mesh.triangulation import frozen
from isoembed.space import Space


@dataclass(frozen=True, eq=False)
class EdgePaths:
    """Geodesic paths between vertices, with their crossings of the edges of a triangulation.

    Attributes
    ----------
    tables : HalfEdges
        Triangulation.
    ends : ndarray of int, shape (n, 2)
        Start and end vertices of the paths.
    offsets : ndarray of int, shape (n + 1,)
        Path e has the crossings ``offsets[e] : offsets[e + 1]``, in order.
    halfedges : ndarray of int, shape (C,)
        Crossed half-edges, of the faces that the paths leave.
    parameters : ndarray, shape (C,)
        Positions of the crossings: fractions of the length, from 0 at the start of the half-edge to 1.
    lengths, distances : ndarray, shape (n,)
        Prescribed lengths of the paths, and distances of their ends in the unfolded triangles; NaN for paths
        that were not found.
    """

    tables: HalfEdges
    ends: Indices
    offsets: Indices
    halfedges: Indices
    parameters: Floats
    lengths: Floats
    distances: Floats

    @property
    def unresolved(self) -> Indices:
        """Indices of the paths that were not found."""
        return np.flatnonzero(np.isnan(self.distances))

    @property
    def point_offsets(self) -> Indices:
        """Offsets of the points of each path in `points`, shape (n + 1,)."""
        return self.offsets + 2 * np.arange(self.offsets.size)

    def points(self, vertices: Floats) -> Floats:
        """Both ends of every path and the crossings between them.

        Parameters
        ----------
        vertices : ndarray, shape (V, d)
            Positions of the vertices of the triangulation, in a `isoembed.space.Space` of its curvature.

        Returns
        -------
        ndarray, shape (C + 2n, d)
            Points, with ``point_offsets[e] : point_offsets[e + 1]`` for path e.
        """
        starts = self.point_offsets
        result = np.empty((starts[-1], vertices.shape[1]))
        between = np.ones(len(result), dtype=np.bool_)
        between[starts[:-1]] = between[starts[1:] - 1] = False
        result[starts[:-1]], result[starts[1:] - 1] = (vertices[v] for v in self.ends.T)
        a, b = (end[self.halfedges] for end in self.tables.ends)
        s = self.parameters[:, None]
        near, far = 1 - s, s
        if self.tables.curvature != 0:
            space, l = Space(self.tables.curvature), self.tables.lengths[self.halfedges, None]
            near, far = space.sn(near * l) / space.sn(l), space.sn(far * l) / space.sn(l)
        result[between] = near * vertices[a] + far * vertices[b]
        return result

    def lengths_on(self, vertices: Floats) -> Floats:
        """Lengths of the polygonal paths through the crossings, shape (n,).

        They are measured on the surface with these vertices, independently of rounding errors in the
        unfolding of thin triangles; NaN for paths that were not found.

        Parameters
        ----------
        vertices : ndarray, shape (V, 3)
            As in `points`.
        """
        points, starts = self.points(vertices), self.point_offsets
        steps = Space(self.tables.curvature).distances(points[1:], points[:-1])
        steps[starts[1:-1] - 1] = 0.0  # from the end of a path to the start of the next
        drawn = np.add.reduceat(steps, starts[:-1])
        return np.where(np.isnan(self.distances), np.nan, drawn)


def edge_paths(original: HalfEdges, final: HalfEdges, polygons: Polygons, halfedges: Indices) -> EdgePaths:
    """Trace edges of one triangulation on another.

    Each edge starts in its direction; the triangles along it are unfolded, and the path is the straight line
    between its ends.

    Parameters
    ----------
    original, final : HalfEdges
        Triangulations of one metric with the same vertices and directions; the final one may have additional
        vertices.
    polygons : Polygons
        Layout of the final triangulation.
    halfedges : ndarray of int, shape (n,)
        Half-edges of the original triangulation to trace.

    Returns
    -------
    EdgePaths
        Paths in the order of `halfedges`.
    """
    lengths = original.lengths[halfedges]
    ends = np.column_stack([end[halfedges] for end in original.ends])
    halfedges, goals = np.ascontiguousarray(halfedges), np.ascontiguousarray(ends[:, 1])
    first, angles = set_out(original.views, final.views, polygons.views, halfedges, 0.0)
    counts, meet = follow(first, angles, lengths, goals, polygons.views)
    # in radians, tried in turn
    for tilt in (1e-11, -1e-11, 1e-10, -1e-10, 1e-9, -1e-9, 1e-8, -1e-8, 1e-7, -1e-7):
        missing = np.flatnonzero(np.isnan(meet.real))
        if missing.size == 0:
            break
        # Along an edge the path missed its end in a triangle as thin as the rounding error of its direction.
        first[missing], angles[missing] = set_out(
            original.views, final.views, polygons.views, halfedges[missing], tilt
        )
        counts[missing], meet[missing] = follow(
            first[missing],
            angles[missing],
            lengths[missing],
            goals[missing],
            polygons.views,
        )
    offsets = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    crossings, parameters = cross_all(first, angles, offsets, meet, polygons.views)
    apart = distances(meet, polygons.curvature)
    for table in (ends, offsets, crossings, parameters, lengths, apart):
        frozen(table)
    return EdgePaths(final, ends, offsets, crossings, parameters, lengths, apart)
