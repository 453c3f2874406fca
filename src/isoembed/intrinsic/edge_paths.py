"""The edges of one triangulation as straight paths across the triangles of another of the same metric."""

import math
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Points
from isoembed.intrinsic.chart import coordinate, distance, distances, stretch, toward
from isoembed.intrinsic.halfedges import HalfEdges, following, leaving_halfedges, preceding
from isoembed.intrinsic.polygons import Polygons, angle_around
from isoembed.intrinsic.tracing import EXTRA_CROSSINGS, crossed, from_corner, place, reaches, sector
from isoembed.intrinsic.trigonometry import cross, norm
from isoembed.kernel import kernel
from isoembed.mesh.triangulation import frozen
from isoembed.space import Space
from isoembed.space.trigonometry import cs, sn


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
    first, angles = _set_out(original, final, polygons, halfedges, 0.0)
    counts, meet = _follow(first, angles, lengths, ends[:, 1], polygons)
    # in radians, one after another
    for tilt in (1e-11, -1e-11, 1e-10, -1e-10, 1e-9, -1e-9, 1e-8, -1e-8, 1e-7, -1e-7):
        lost = np.flatnonzero(np.isnan(meet.real))
        if lost.size == 0:
            break
        # Beside an edge it passed its end in a triangle that is as thin as its direction is rounded.
        first[lost], angles[lost] = _set_out(original, final, polygons, halfedges[lost], tilt)
        counts[lost], meet[lost] = _follow(first[lost], angles[lost], lengths[lost], ends[lost, 1], polygons)
    offsets = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    crossings, parameters = _cross(first, angles, offsets, meet, polygons)
    apart = distances(meet, polygons.curvature)
    for table in (ends, offsets, crossings, parameters, lengths, apart):
        frozen(table)
    return EdgePaths(final, ends, offsets, crossings, parameters, lengths, apart)


@kernel
def _set_out(
    original: HalfEdges, final: HalfEdges, polygons: Polygons, halfedges: Indices, tilt: float
) -> tuple[Indices, Floats]:
    """The half-edges next clockwise of those given, which are turned by so much, and the angles between."""
    number = np.full(original.corners.size, -1, dtype=np.int64)
    for e in range(halfedges.size):
        number[halfedges[e]] = e
    first, angles = np.empty(halfedges.size, dtype=np.int64), np.empty(halfedges.size)
    n = original.corners.max() + 1
    old = leaving_halfedges(original.corners, n)
    new = leaving_halfedges(final.corners, final.corners.max() + 1)
    for v in range(n):
        total = angle_around(new[v], polygons)
        # Both go counterclockwise, so that the search begins where the last one ended.
        h, g = old[v], new[v]
        while True:
            e = number[h]
            if e >= 0:
                g, angle = sector(g, original.directions[h] + tilt, total, final)
                first[e], angles[e] = g, angle
            h = original.twins[preceding(h)]
            if h == old[v]:
                break
    return first, angles


@kernel
def _follow(
    first: Indices, angles: Floats, lengths: Floats, goals: Indices, polygons: Polygons
) -> tuple[Indices, Points]:
    """Crossings of each path, and where it ends if it sets out along the x axis; not a number if astray."""
    corners, curvature = polygons.corners, polygons.curvature
    counts, meet = np.zeros(first.size, dtype=np.int64), np.full(first.size, complex(np.nan, np.nan))
    for e in range(first.size):
        far = lengths[e]
        goal = complex(coordinate(far, curvature), 0.0)
        state = from_corner(first[e], angles[e], polygons)
        # rounding of a place, in coordinates; a path that misses by 1e-6 of its length went elsewhere
        near = 1e-6 * far + 2.0**-48 * (norm(polygons.z[first[e]]) + norm(polygons.z[state[0]]))
        found = False
        for g in (state[0], following(state[0])):
            end = place(g, state, polygons)
            if not found and corners[g] == goals[e] and norm(toward(goal, end, curvature)) <= near:
                meet[e], found = end, True
        if found:
            continue
        for k in range(corners.size + EXTRA_CROSSINGS):
            if reaches(state, far + near, polygons):
                break
            g = preceding(polygons.twins[state[0]])
            state = crossed(state, polygons)
            end = place(g, state, polygons)
            if np.isnan(end.real):  # by triangles too thin for a direction: round a vertex for ever
                break
            if corners[g] == goals[e] and norm(toward(goal, end, curvature)) <= near:
                meet[e], counts[e] = end, k + 1
                break
    return counts, meet


@kernel
def _cross(
    first: Indices, angles: Floats, offsets: Indices, meet: Points, polygons: Polygons
) -> tuple[Indices, Floats]:
    """Half-edges that are crossed, and where, by paths from the origin straight to where they end."""
    halfedges, parameters = np.empty(offsets[-1], dtype=np.int64), np.empty(offsets[-1])
    for e in range(first.size):
        if offsets[e] == offsets[e + 1]:
            continue
        state = from_corner(first[e], angles[e], polygons)
        for k in range(offsets[e], offsets[e + 1]):
            halfedges[k] = state[0]
            lower = place(state[0], state, polygons)
            upper = place(following(state[0]), state, polygons)
            below, above = cross(lower, meet[e]), cross(meet[e], upper)
            parameters[k] = _parameter(lower, upper, below, above, polygons.curvature)
            state = crossed(state, polygons)
    return halfedges, parameters


@kernel
def _parameter(lower: complex, upper: complex, below: float, above: float, k: float) -> float:
    """Where a side is crossed by a line on which its ends have these products: part of its length."""
    if k == 0:
        along = below + above
        return min(max(below / along, 0.0), 1.0) if along > 0 else 0.5
    # On hyperboloid or sphere the crossing is `above` times one end and `below` times the other.
    below, above = max(below / stretch(lower, k), 0.0), max(above / stretch(upper, k), 0.0)
    length = distance(toward(lower, upper, k), k)
    sine, cosine = below * sn(length, k), above + below * cs(length, k)
    if not (below + above > 0 and length > 0):
        return 0.5
    root = np.sqrt(abs(k))
    if k > 0:
        return min(math.atan2(root * sine, cosine) / (root * length), 1.0)
    return min(math.atanh(min(root * sine / cosine, 1.0 - 2.0**-53)) / (root * length), 1.0)
