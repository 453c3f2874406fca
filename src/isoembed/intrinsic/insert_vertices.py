"""Flat vertices put back into a triangulation that was flipped while they were away."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric
from isoembed.intrinsic.flat_vertices import Removal
from isoembed.intrinsic.flips import HalfEdges, apex, preceding
from isoembed.intrinsic.local_delaunay import half_edges_leaving, push
from isoembed.intrinsic.multi_edges import remove_multi_edges
from isoembed.intrinsic.planar import first_sides, flip_to_delaunay, insert, lay_out
from isoembed.intrinsic.tracing import from_corner, from_inside, sector, straight, total_angle
from isoembed.mesh.triangulation import frozen

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Table = TypeVar("Table", bound=NDArray)


@dataclass(frozen=True, eq=False)
class Restored:
    """A triangulation with all vertices, and where in the faces without the flat ones these lie.

    Attributes
    ----------
    tables : HalfEdges
        Vertices numbered, and directions measured, as before the removal.
    kept : ndarray of bool, shape (3F,)
        The half-edges of ``tables`` that are parts of the edges that were to be kept.
    core, flat : ndarray of int
        The vertices that had stayed, and those that were put back, both ascending.
    faces : ndarray of int, shape (n,)
        For every flat vertex the face, of those without flat vertices, in which it lies.
    barycentric : ndarray, shape (n, 3)
        And how much of the three corners it is; not negative, sum 1.
    corners : ndarray of int, shape (n, 3)
        The three corners, in the numbers of the triangulation without flat vertices.
    """

    tables: HalfEdges
    kept: Mask
    core: Indices
    flat: Indices
    faces: Indices
    barycentric: Floats
    corners: Indices

    def vertices(self, core: Floats) -> Floats:
        """Positions of all vertices from those of the core, if its faces are flat triangles.

        Parameters
        ----------
        core : ndarray, shape (V - n, 3)

        Returns
        -------
        ndarray, shape (V, 3)
        """
        result = np.empty((self.core.size + self.flat.size, core.shape[1]))
        result[self.core] = core
        result[self.flat] = np.einsum("nc,ncd->nd", self.barycentric, core[self.corners])
        return result


def insert_vertices(tables: HalfEdges, removal: Removal, kept: Mask) -> Restored:
    """Put flat vertices back, and make the triangles good between the edges that are to be kept.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation without them, its vertices numbered and directions measured as by
        `remove_flat_vertices`.
    removal : Removal
    kept : ndarray of bool, shape (3F,)
        The half-edges of both sides of the edges that are not to be flipped: those at which the surface is
        to be bent.  Vertices on them split them.

    Returns
    -------
    Restored
        With triangles that are Delaunay but for the edges kept, and but for what keeps loops and edges with
        the same two ends away: of a convex polyhedron whose edges are all kept there are none, and of a
        polygon covered twice none as long as its outline admits it.

    Raises
    ------
    InvalidMetric
        A vertex is not to be found, because these are other triangles or thin beyond measure.
    """
    r, n = removal, removal.removed.size
    number = np.full(r.core.size + n, -1, dtype=np.int64)  # in the core
    number[r.core] = np.arange(r.core.size)
    faces, barycentric, axis, lost = _locate(
        tables.corners, tables.twins, tables.lengths, tables.directions,
        r.removed, r.anchors, r.directions, r.distances, r.backs, number,
    )  # fmt: skip
    if lost >= 0:
        raise InvalidMetric(
            f"vertex {lost}, which is flat, is not found again: the triangles around it are too thin"
        )

    cells, x, y, fixed = lay_out(tables.twins, tables.lengths, kept)
    slopes = np.arctan2(_next(y) - y, _next(x) - x)
    at = 3 * faces[:, None] + np.arange(3)
    px, py = np.einsum("vc,vc->v", barycentric, x[at]), np.einsum("vc,vc->v", barycentric, y[at])
    axis -= slopes[3 * faces]
    frames = _grown(first_sides(tables.twins, fixed), 6 * n)
    axes, slopes = _grown(tables.directions, 6 * n), _grown(slopes, 6 * n)
    corners, twins = _grown(r.core[tables.corners], 6 * n), _grown(tables.twins, 6 * n)
    x, y, kept, fixed = _grown(x, 6 * n), _grown(y, 6 * n), _grown(kept, 6 * n), _grown(fixed, 6 * n)
    _insert_all(
        r.removed, r.anchors, px, py, axis, faces, corners, twins, x, y, frames, axes, kept, fixed,
        _grown(cells, 2 * n), tables.corners.size,
    )  # fmt: skip
    dx, dy = _next(x) - x, _next(y) - y
    lengths = np.hypot(dx, dy)
    lengths = np.minimum(lengths, lengths[twins])  # between polygons they differ by rounding
    # A frame gives the direction of a side of the polygon, or of the x axis if the vertex was flat; half a
    # radian takes up what rounding puts before that.
    turns = (np.arctan2(dy, dx) - slopes[frames] + 0.5) % (2 * np.pi) - 0.5
    result = HalfEdges(corners, twins, lengths, axes[frames] + turns)
    remove_multi_edges(result, kept)
    flat = np.flatnonzero(number < 0)
    return Restored(
        result,
        frozen(kept),
        r.core,
        frozen(flat),
        frozen(faces[flat]),
        frozen(barycentric[flat]),
        frozen(tables.faces[faces[flat]]),
    )


def _grown(table: Table, by: int) -> Table:
    """A copy with room for more."""
    return np.concatenate([table, np.zeros(by, dtype=table.dtype)])  # type: ignore[return-value]


def _next(values: Floats) -> Floats:
    """What the next half-edge of each face has."""
    return np.roll(values.reshape(-1, 3), -1, axis=1).ravel()


@njit(cache=True)
def _insert_all(
    removed: Indices,
    anchors: Indices,
    px: Floats,
    py: Floats,
    axis: Floats,
    faces: Indices,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    axes: Floats,
    kept: Mask,
    fixed: Mask,
    cells: Indices,
    new: int,
) -> None:
    """Insert the removed vertices into tables of which so much is in use."""
    waiting = np.zeros(corners.size, dtype=np.bool_)
    stack = np.empty(corners.size, dtype=np.int64)
    leaving = half_edges_leaving(corners[:new], px.size)
    top = 0
    for h in range(new):
        top = push(h, stack, top, waiting, twins)
    flip_to_delaunay(stack, top, waiting, corners, twins, x, y, frames, kept, fixed, leaving)
    for k in range(removed.size - 1, -1, -1):
        v = removed[k]
        start = _face_near(leaving[anchors[k]], faces[v], twins, cells)
        insert(
            v, px[v], py[v], axis[v], start, new,
            corners, twins, x, y, frames, axes, kept, fixed, cells, leaving, stack, waiting,
        )  # fmt: skip
        new += 6


@njit(cache=True)
def _face_near(h: int, f: int, twins: Indices, cells: Indices) -> int:
    """A face at the vertex that a half-edge leaves, in the polygon of face f; or else f."""
    e = h
    while cells[e // 3] != cells[f]:
        e = twins[preceding(e)]
        if e == h:
            return f
    return e // 3


@njit(cache=True)
def _locate(
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    removed: Indices,
    anchors: Indices,
    ways: Floats,
    distances: Floats,
    backs: Floats,
    number: Indices,
) -> tuple[Indices, Floats, Floats, int]:
    """The faces in which the removed vertices lie, and where: barycentric coordinates.

    Returns
    -------
    ndarray of int, shape (V,)
    ndarray, shape (V, 3)
    ndarray, shape (V,)
        The direction at the vertex that is that of the first half-edge of the face.
    int
        A vertex that is lost, or -1.
    """
    n = number.size
    faces = np.zeros(n, dtype=np.int64)
    barycentric = np.zeros((n, 3))
    axis = np.zeros(n)
    x, y = np.empty(n), np.empty(n)  # in the face, whose first half-edge is the x axis
    leaving = half_edges_leaving(corners, n - removed.size)
    for k in range(removed.size - 1, -1, -1):
        v, u = removed[k], anchors[k]
        if number[u] >= 0:
            h = leaving[number[u]]
            h, offset = sector(h, ways[k], total_angle(h, twins, lengths), twins, directions)
            state = from_corner(h, offset, lengths)
        else:
            state = from_inside(faces[u], x[u], y[u], ways[k] - axis[u], lengths)
        out, px, py, qx, qy, rx, ry = straight(state, distances[k], twins, lengths)
        if out < 0:
            return faces, barycentric, axis, v
        f, c = out // 3, out % 3
        px, qx, rx = px - distances[k], qx - distances[k], rx - distances[k]
        at_p, at_q = max(qx * ry - qy * rx, 0.0), max(rx * py - ry * px, 0.0)
        at_r = max(px * qy - py * qx, 0.0)
        total = at_p + at_q + at_r
        barycentric[v, c] = at_p / total
        barycentric[v, (c + 1) % 3] = at_q / total
        barycentric[v, (c + 2) % 3] = at_r / total
        l = lengths[3 * f]
        ax, ay = apex(l, lengths[3 * f + 1], lengths[3 * f + 2])
        faces[v] = f
        x[v], y[v] = barycentric[v, 1] * l + barycentric[v, 2] * ax, barycentric[v, 2] * ay
        if c == 0:
            slope = np.arctan2(qy - py, qx - px)
        elif c == 1:
            slope = np.arctan2(py - ry, px - rx)
        else:
            slope = np.arctan2(ry - qy, rx - qx)
        axis[v] = backs[k] - np.pi + slope
    return faces, barycentric, axis, -1
