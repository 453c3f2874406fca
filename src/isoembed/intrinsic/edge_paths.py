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
    """Straight paths from vertex to vertex, and where they cross the edges of a triangulation.

    Attributes
    ----------
    tables : HalfEdges
        The triangulation.
    ends : ndarray of int, shape (n, 2)
        The vertices from which and to which the paths lead.
    offsets : ndarray of int, shape (n + 1,)
        Path e has the crossings from ``offsets[e]`` to before ``offsets[e + 1]``, in order.
    halfedges : ndarray of int, shape (C,)
        The half-edge that is crossed, of the face that the path leaves.
    parameters : ndarray, shape (C,)
        Where: 0 at the vertex that the half-edge leaves, 1 at the other, in proportion to the length.
    lengths, distances : ndarray, shape (n,)
        Length that the path is to have, and distance of its ends once its triangles are unfolded; not a
        number if it has not been found.
    """

    tables: HalfEdges
    ends: Indices
    offsets: Indices
    halfedges: Indices
    parameters: Floats
    lengths: Floats
    distances: Floats

    @property
    def lost(self) -> Indices:
        """The paths that do not lead to their end."""
        return np.flatnonzero(np.isnan(self.distances))

    @property
    def point_offsets(self) -> Indices:
        """(n + 1,): where the points of each path begin in `points`."""
        return self.offsets + 2 * np.arange(self.offsets.size)

    def points(self, vertices: Floats) -> Floats:
        """Both ends of every path and the crossings between.

        Parameters
        ----------
        vertices : ndarray, shape (V, d)
            Positions of the vertices of the triangulation, in a `isoembed.space.Space` of its curvature.

        Returns
        -------
        ndarray, shape (C + 2n, d)
            Path e from ``point_offsets[e]`` to before ``point_offsets[e + 1]``.
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
        """Lengths of the paths as they are drawn through their crossings, shape (n,).

        They are of the surface that these vertices span, whatever rounding does to its thin triangles when
        they are unfolded; not a number for paths that have not been found.

        Parameters
        ----------
        vertices : ndarray, shape (V, 3)
            As of `points`.
        """
        points, starts = self.points(vertices), self.point_offsets
        steps = Space(self.tables.curvature).distances(points[1:], points[:-1])
        steps[starts[1:-1] - 1] = 0.0  # from the end of a path to the start of the next
        drawn = np.add.reduceat(steps, starts[:-1])
        return np.where(np.isnan(self.distances), np.nan, drawn)


def edge_paths(original: HalfEdges, final: HalfEdges, polygons: Polygons, halfedges: Indices) -> EdgePaths:
    """Draw edges of one triangulation on another.

    An edge sets out in its direction; the triangles that it meets are unfolded, and the path is drawn
    straight from end to end.

    Parameters
    ----------
    original, final : HalfEdges
        Triangulations of one metric, with the same vertices and directions; the final one may have more.
    polygons : Polygons
        The final one, laid out.
    halfedges : ndarray of int, shape (n,)
        Of the original: one for each path that is wanted, from the vertex that it leaves.

    Returns
    -------
    EdgePaths
        In the order of `halfedges`.
    """
    lengths = original.lengths[halfedges]
    ends = np.column_stack([end[halfedges] for end in original.ends])
    halfedges, goals = np.ascontiguousarray(halfedges), np.ascontiguousarray(ends[:, 1])
    first, angles = set_out(original.views, final.views, polygons.views, halfedges, 0.0)
    counts, meet = follow(first, angles, lengths, goals, polygons.views)
    # in radians, one after another
    for tilt in (1e-11, -1e-11, 1e-10, -1e-10, 1e-9, -1e-9, 1e-8, -1e-8, 1e-7, -1e-7):
        lost = np.flatnonzero(np.isnan(meet.real))
        if lost.size == 0:
            break
        # Beside an edge it passed its end in a triangle that is as thin as its direction is rounded.
        first[lost], angles[lost] = set_out(
            original.views, final.views, polygons.views, halfedges[lost], tilt
        )
        counts[lost], meet[lost] = follow(
            first[lost], angles[lost], lengths[lost], goals[lost], polygons.views
        )
    offsets = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    crossings, parameters = cross_all(first, angles, offsets, meet, polygons.views)
    apart = distances(meet, polygons.curvature)
    for table in (ends, offsets, crossings, parameters, lengths, apart):
        frozen(table)
    return EdgePaths(final, ends, offsets, crossings, parameters, lengths, apart)
