"""The edges of one triangulation as straight paths across the triangles of another of the same metric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.intrinsic.flips import HalfEdges, following, preceding
from isoembed.intrinsic.local_delaunay import half_edges_leaving
from isoembed.intrinsic.tracing import LONGEST, crossed, from_corner, reaches, sector, total_angle
from isoembed.mesh.triangulation import frozen

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ASTRAY = 1e-6  # of its length: a path that misses its end by more went elsewhere


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
        Where: 0 at the vertex that the half-edge leaves, 1 at the other.
    lengths, distances : ndarray, shape (n,)
        Length that the path is to have, and distance of its ends once its triangles are unfolded into the
        plane; not a number if it has not been found.
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
    def mismatch(self) -> float:
        """Largest difference between length and distance, over the mean length; infinite if one is lost."""
        if self.lost.size:
            return np.inf
        return float(np.abs(self.distances - self.lengths).max() / self.lengths.mean())

    @property
    def point_offsets(self) -> Indices:
        """(n + 1,): where the points of each path begin in `points`."""
        return self.offsets + 2 * np.arange(self.offsets.size)

    def points(self, vertices: Floats) -> Floats:
        """Both ends of every path and the crossings between.

        Parameters
        ----------
        vertices : ndarray, shape (V, d)
            Positions of the vertices of the triangulation.

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
        a = self.tables.corners[self.halfedges]
        b = self.tables.corners[self.tables.twins[self.halfedges]]
        s = self.parameters[:, None]
        result[between] = (1 - s) * vertices[a] + s * vertices[b]
        return result


def edge_paths(original: HalfEdges, final: HalfEdges, halfedges: Indices) -> EdgePaths:
    """Draw edges of one triangulation on another.

    An edge sets out in its direction; the triangles that it meets are unfolded into the plane, and there the
    path is drawn straight from end to end.

    Parameters
    ----------
    original, final : HalfEdges
        Triangulations of one metric, with the same vertices and directions.
    halfedges : ndarray of int, shape (n,)
        Of the original: one for each path that is wanted, from the vertex that it leaves.

    Returns
    -------
    EdgePaths
        In the order of `halfedges`.
    """
    n = halfedges.size
    lengths = original.lengths[halfedges]
    ends = np.column_stack([original.corners[halfedges], original.corners[original.twins[halfedges]]])
    first, angles = _set_out(
        original.corners, original.twins, original.directions, final.corners, final.twins, final.lengths,
        final.directions, halfedges,
    )  # fmt: skip
    counts = np.empty(n, dtype=np.int64)
    meet = np.empty((n, 2))  # where the paths end, if they set out from the origin along the x axis
    _follow(first, angles, lengths, ends[:, 1], final.corners, final.twins, final.lengths, counts, meet)
    offsets = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    crossings, parameters = np.empty(offsets[-1], dtype=np.int64), np.empty(offsets[-1])
    _cross(first, angles, final.twins, final.lengths, offsets, meet, crossings, parameters)
    return EdgePaths(
        final,
        frozen(ends),
        frozen(offsets),
        frozen(crossings),
        frozen(parameters),
        frozen(lengths),
        frozen(np.hypot(meet[:, 0], meet[:, 1])),
    )


@njit(cache=True)
def _set_out(
    corners: Indices,
    twins: Indices,
    directions: Floats,
    final_corners: Indices,
    final_twins: Indices,
    final_lengths: Floats,
    final_directions: Floats,
    halfedges: Indices,
) -> tuple[Indices, Floats]:
    """The half-edges next clockwise of those given, and the angles between."""
    number = np.full(corners.size, -1, dtype=np.int64)
    for e in range(halfedges.size):
        number[halfedges[e]] = e
    first, angles = np.empty(halfedges.size, dtype=np.int64), np.empty(halfedges.size)
    n = corners.max() + 1
    old, new = half_edges_leaving(corners, n), half_edges_leaving(final_corners, n)
    for v in range(n):
        total = total_angle(new[v], final_twins, final_lengths)
        # Both go counterclockwise, so that the search begins where the last one ended.
        h, g = old[v], new[v]
        while True:
            e = number[h]
            if e >= 0:
                g, angle = sector(g, directions[h], total, final_twins, final_directions)
                first[e], angles[e] = g, angle
            h = twins[preceding(h)]
            if h == old[v]:
                break
    return first, angles


@njit(cache=True)
def _follow(
    first: Indices,
    angles: Floats,
    distances: Floats,
    goals: Indices,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    counts: Indices,
    meet: Floats,
) -> None:
    """Count the edges that the paths cross, and say where they end; not a number if they go astray."""
    for e in range(first.size):
        far = distances[e]
        near = ASTRAY * far
        counts[e] = 0
        state = from_corner(first[e], angles[e], lengths)
        out, lx, ly, ux, uy, _, _ = state
        after = following(out)
        if corners[out] == goals[e] and np.hypot(lx - far, ly) <= near:
            meet[e, 0], meet[e, 1] = lx, ly
            continue
        if corners[after] == goals[e] and np.hypot(ux - far, uy) <= near:
            meet[e, 0], meet[e, 1] = ux, uy
            continue
        meet[e, 0] = meet[e, 1] = np.nan
        for k in range(twins.size + LONGEST):
            if reaches(state, far + near):
                break
            g = preceding(twins[state[0]])
            state = crossed(state, twins, lengths)
            # The corner that is new is one end of the side through which the path leaves.
            x, y = (state[3], state[4]) if following(state[0]) == g else (state[1], state[2])
            if corners[g] == goals[e] and np.hypot(x - far, y) <= near:
                meet[e, 0], meet[e, 1] = x, y
                counts[e] = k + 1
                break


@njit(cache=True)
def _cross(
    first: Indices,
    angles: Floats,
    twins: Indices,
    lengths: Floats,
    offsets: Indices,
    meet: Floats,
    halfedges: Indices,
    parameters: Floats,
) -> None:
    """Fill in the crossings of paths from the origin straight to where they end."""
    for e in range(first.size):
        if offsets[e] == offsets[e + 1]:
            continue
        x, y = meet[e]
        state = from_corner(first[e], angles[e], lengths)
        for k in range(offsets[e], offsets[e + 1]):
            out, lx, ly, ux, uy, _, _ = state
            below, above = y * lx - x * ly, x * uy - y * ux
            halfedges[k] = out
            along = below + above
            parameters[k] = min(max(below / along, 0.0), 1.0) if along > 0 else 0.5
            state = crossed(state, twins, lengths)
