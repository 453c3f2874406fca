"""New vertices in the plane polygons that triangles form between edges that are kept, triangulated well.

Lengths alone would not do: to flip a triangle a thousand times longer than high loses three digits, and to
flip it again three more.  Here every corner of a triangle has coordinates, which no flip changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.delaunay import (
    BLOCKED,
    DELAUNAY,
    FLIPPED,
    LEFT,
    attempts,
    push,
    restore_delaunay,
)
from isoembed.intrinsic.flips import swap_diagonals
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, following, glue, preceding, third_corner
from isoembed.intrinsic.kernel import kernel
from isoembed.thresholds import compiled, threshold


@dataclass(frozen=True)
class PlanarThresholds:
    """Thresholds of triangles laid out in the plane."""

    straight: float = threshold(1e-9, "radians", "Excess over pi of a polygon's corner, or of two angles.")
    # Sides that are longer than the third by less make no triangle in floats: the vertex is 2e-8 of it off.
    on_side: float = threshold(
        1e-15, "side lengths", "Detour by way of a vertex that is put on a fixed side."
    )
    # A side that may be flipped anyway is split early, which spares two thin triangles.
    near_side: float = threshold(
        1e-6, "side lengths", "Detour by way of a vertex that is put on another side."
    )


PLANAR = PlanarThresholds()
_T, _D = compiled(PLANAR), compiled(DELAUNAY)


class Polygons(NamedTuple):
    """Triangles laid out in polygons of the plane.

    Attributes
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As of `HalfEdges`.
    x, y : ndarray, shape (3F,)
        Coordinates of the corners, continuous in each polygon.
    fixed : ndarray of bool, shape (3F,)
        The half-edges between polygons.
    cells : ndarray of int64, shape (F,)
        To which polygon a face belongs.
    """

    corners: Indices
    twins: Indices
    x: Floats
    y: Floats
    fixed: Mask
    cells: Indices


class Marks(NamedTuple):
    """What flips and splits of polygons carry along.

    Attributes
    ----------
    kept : ndarray of bool, shape (3F,)
        The half-edges of edges that are kept.
    frames : ndarray of int64, shape (3F,)
        Where in `axes` the direction of a corner's vertex that is the x axis is to be found.
    axes : ndarray, shape (3F,)
    leaving : ndarray of int64, shape (V,)
        A half-edge that leaves each vertex.
    """

    kept: Mask
    frames: Indices
    axes: Floats
    leaving: Indices


@kernel
def lay_out(mesh: HalfEdges, kept: Mask) -> Polygons:
    """Unfold the triangles between kept edges; where these bound no convex polygons, each triangle is one."""
    twins, lengths = mesh.twins, mesh.lengths
    n = twins.size // 3
    fixed = kept.copy()
    cells = _cells(twins, fixed)
    plane = _are_convex(cells, mesh, fixed)
    for h in range(3 * n):
        if not plane[cells[h // 3]]:
            fixed[h] = True
    cells = _cells(twins, fixed)

    x, y = np.zeros(3 * n), np.zeros(3 * n)
    placed = np.zeros(n, dtype=np.bool_)
    stack = np.empty(n, dtype=np.int64)
    for first in range(n):
        if placed[first]:
            continue
        h = 3 * first
        x[h + 1] = lengths[h]
        x[h + 2], y[h + 2] = third_corner(h, 0.0, 0.0, lengths[h], 0.0, lengths)
        placed[first] = True
        stack[0], top = first, 1
        while top > 0:
            top -= 1
            f = stack[top]
            for h in range(3 * f, 3 * f + 3):
                t = twins[h]
                if fixed[h] or placed[t // 3]:
                    continue
                a, b = following(t), preceding(t)
                x[a], y[a] = x[h], y[h]
                x[t], y[t] = x[following(h)], y[following(h)]
                x[b], y[b] = third_corner(t, x[t], y[t], x[a], y[a], lengths)
                placed[t // 3] = True
                stack[top] = t // 3
                top += 1
    return Polygons(mesh.corners, twins, x, y, fixed, cells)


@kernel
def _cells(twins: Indices, fixed: Mask) -> Indices:
    """Number the connected sets of faces between fixed edges, shape (F,)."""
    n = twins.size // 3
    cells = np.full(n, -1, dtype=np.int64)
    stack = np.empty(n, dtype=np.int64)
    number = 0
    for first in range(n):
        if cells[first] >= 0:
            continue
        cells[first] = number
        stack[0], top = first, 1
        while top > 0:
            top -= 1
            f = stack[top]
            for h in range(3 * f, 3 * f + 3):
                g = twins[h] // 3
                if not fixed[h] and cells[g] < 0:
                    cells[g] = number
                    stack[top] = g
                    top += 1
        number += 1
    return cells


@kernel
def _are_convex(cells: Indices, mesh: HalfEdges, fixed: Mask) -> Mask:
    """Which cells are convex polygons, by number.

    A cell of n faces that hang together at n - 1 edges has no vertex inside and no hole; and if it has no
    reflex corner either, it does not overlap itself.
    """
    n = int(cells.max()) + 1
    inner = np.zeros(n, dtype=np.int64)
    size = np.zeros(n, dtype=np.int64)
    convex = np.ones(n, dtype=np.bool_)
    for h in range(fixed.size):
        c = cells[h // 3]
        if h % 3 == 0:
            size[c] += 1
        if not fixed[h]:
            inner[c] += 1
        else:
            # The corner from this side counterclockwise to the one before it.
            angle = 0.0
            e = h
            for _ in range(fixed.size):
                angle += corner_angle(e, mesh.lengths)
                if fixed[preceding(e)]:
                    break
                e = mesh.twins[preceding(e)]
            if angle > np.pi + _T.straight:
                convex[c] = False
    return convex & (inner == 2 * (size - 1))


@kernel
def first_sides(twins: Indices, fixed: Mask) -> Indices:
    """The side of the polygon that comes first counterclockwise at each corner of each face, shape (3F,)."""
    first = np.empty(twins.size, dtype=np.int64)
    for h in range(twins.size):
        if fixed[h]:
            e = h
            while True:
                first[e] = h
                into = preceding(e)
                if fixed[into]:
                    break
                e = twins[into]
    return first


@kernel
def insert(
    v: int, px: float, py: float, start: int, new: int, polygons: Polygons, marks: Marks, stack: Indices
) -> None:
    """Insert a vertex into a polygon.

    Parameters
    ----------
    v : int
    px, py : float
        Its coordinates.
    start : int
        A face of the polygon from which it is to be searched.
    new : int
        Six half-edges from here on are unused, but ``marks.axes[new]`` is its direction that is the x axis.
    polygons : Polygons
    marks : Marks
    stack : ndarray
        Of `isoembed.intrinsic.delaunay`, empty.
    """
    twins = polygons.twins
    f = face_at(px, py, start, polygons, new // 3)
    s = _side_at(px, py, f, polygons)
    if s < 0:
        g = f
        _split_face(v, px, py, 3 * f, new, polygons, marks)
    else:
        qx, qy, turn = _across(px, py, s, twins[s], polygons)
        marks.axes[new + 3] = marks.axes[new] + turn
        _split_side(v, px, py, s, new, polygons, marks)
        t = twins[s]
        g = t // 3
        _split_side(v, qx, qy, t, new + 3, polygons, marks)
        glue(twins[t], new + 3, twins)
        glue(t, new, twins)
    for first in (3 * f, 3 * g, new, new + 3):
        for h in range(first, first + 3):
            marks.leaving[polygons.corners[h]] = h
            push(h, stack, twins)
    restore_delaunay(stack, polygons, marks)


@kernel
def face_at(px: float, py: float, start: int, polygons: Polygons, n: int) -> int:
    """Face of a polygon in which a point lies, or nearly so, of n faces; the search begins at another."""
    f, came = start, -1
    for _ in range(n):
        go, least = -1, 0.0
        for h in range(3 * f, 3 * f + 3):
            distance = _distance(px, py, h, polygons)
            if h != came and not polygons.fixed[h] and distance < least:
                go, least = h, distance
        if go < 0:
            break
        came = polygons.twins[go]
        f = came // 3
    best = _depth(px, py, f, polygons)
    if best < -_T.straight:  # led astray: try all
        for g in range(n):
            if polygons.cells[g] == polygons.cells[start]:
                depth = _depth(px, py, g, polygons)
                if depth > best:
                    f, best = g, depth
    return f


@kernel
def _distance(px: float, py: float, h: int, polygons: Polygons) -> float:
    """Signed distance of a point from the line of a half-edge, positive inside, over the length of that."""
    x, y, e = polygons.x, polygons.y, following(h)
    u, v = x[e] - x[h], y[e] - y[h]
    return (u * (py - y[h]) - v * (px - x[h])) / (u * u + v * v)


@kernel
def _depth(px: float, py: float, f: int, polygons: Polygons) -> float:
    return min(
        _distance(px, py, 3 * f, polygons),
        _distance(px, py, 3 * f + 1, polygons),
        _distance(px, py, 3 * f + 2, polygons),
    )


@kernel
def _side_at(px: float, py: float, f: int, polygons: Polygons) -> int:
    """The half-edge of a face that is to be split by a point in it; -1 if the point is well inside."""
    x, y, fixed = polygons.x, polygons.y, polygons.fixed
    least, s = 1.0, -1
    for h in range(3 * f, 3 * f + 3):
        e = following(h)
        l = np.hypot(x[e] - x[h], y[e] - y[h])
        height = _distance(px, py, h, polygons)
        foot = ((px - x[h]) * (x[e] - x[h]) + (py - y[h]) * (y[e] - y[h])) / (l * l)
        detour = 0.0
        if height > 0:
            for along in (foot, 1 - foot):
                way = np.hypot(along, height)
                detour += height**2 / (way + along) if along > 0 else way - along
        # A side that may not be flipped comes first: a point on it that is put on another is never put on it.
        share = detour / _T.on_side - 1 if fixed[h] else detour / _T.near_side
        if share < least and not (fixed[h] and share >= 0):
            least, s = share, h
    if s >= 0:
        t = polygons.twins[s]
        qx, qy, _ = _across(px, py, s, t, polygons)
        if not (_cuts(px, py, s, polygons) and _cuts(qx, qy, t, polygons)):
            return -1
    return s


@kernel
def _across(px: float, py: float, s: int, t: int, polygons: Polygons) -> tuple[float, float, float]:
    """A point near a side in the coordinates of the face across, and by what angle to these the axes turn."""
    x, y, a, b = polygons.x, polygons.y, following(s), following(t)
    u, v = x[a] - x[s], y[a] - y[s]
    p, q = x[t] - x[b], y[t] - y[b]
    size = u * u + v * v
    c, d = (p * u + q * v) / size, (q * u - p * v) / size
    return (
        x[b] + c * (px - x[s]) - d * (py - y[s]),
        y[b] + c * (py - y[s]) + d * (px - x[s]),
        -np.arctan2(d, c),
    )


@kernel
def _cuts(px: float, py: float, s: int, polygons: Polygons) -> bool:
    """Whether a point on a side and the corner across make two triangles of which neither is turned over."""
    x, y, a, b = polygons.x, polygons.y, following(s), preceding(s)
    return (x[s] - x[b]) * (py - y[b]) > (y[s] - y[b]) * (px - x[b]) and (px - x[b]) * (y[a] - y[b]) > (
        py - y[b]
    ) * (x[a] - x[b])


@kernel
def _split_face(v: int, px: float, py: float, a: int, new: int, polygons: Polygons, marks: Marks) -> None:
    """Join a vertex to the corners of the face of half-edge a."""
    b, c = following(a), preceding(a)
    m, n = new, new + 3
    polygons.cells[m // 3] = polygons.cells[n // 3] = polygons.cells[a // 3]
    for h, to in ((b, m), (c, n)):
        _copy(h, to, polygons, marks)
        glue(to, polygons.twins[h], polygons.twins)
    for away, back, start in ((c, n + 1, a), (m + 2, b, m), (n + 2, m + 1, n)):
        _copy(start, back, polygons, marks)
        _set_corner(away, v, px, py, new, polygons, marks)
        _join(away, back, polygons, marks)


@kernel
def _split_side(v: int, px: float, py: float, s: int, m: int, polygons: Polygons, marks: Marks) -> None:
    """Put a vertex on half-edge s and join it to the corner across; its second part m is not glued."""
    a, b = following(s), preceding(s)
    polygons.cells[m // 3] = polygons.cells[s // 3]
    _copy(a, m + 1, polygons, marks)
    glue(m + 1, polygons.twins[a], polygons.twins)
    _copy(b, m + 2, polygons, marks)
    _copy(s, m, polygons, marks)
    for away in (a, m):
        _set_corner(away, v, px, py, m, polygons, marks)
    _join(a, m + 2, polygons, marks)


@kernel
def _copy(h: int, to: int, polygons: Polygons, marks: Marks) -> None:
    """Copy all that is known of a half-edge but its twin."""
    polygons.corners[to], polygons.x[to], polygons.y[to] = polygons.corners[h], polygons.x[h], polygons.y[h]
    polygons.fixed[to], marks.kept[to], marks.frames[to] = polygons.fixed[h], marks.kept[h], marks.frames[h]


@kernel
def _set_corner(h: int, v: int, px: float, py: float, frame: int, polygons: Polygons, marks: Marks) -> None:
    polygons.corners[h], polygons.x[h], polygons.y[h], marks.frames[h] = v, px, py, frame


@kernel
def _join(g: int, h: int, polygons: Polygons, marks: Marks) -> None:
    """Make two half-edges an edge inside a polygon."""
    glue(g, h, polygons.twins)
    marks.kept[g] = marks.kept[h] = polygons.fixed[g] = polygons.fixed[h] = False


@attempts(Marks)
def _attempt(h: int, mesh: Polygons, rule: Marks) -> int:
    """The rule of a Delaunay triangulation of the polygons."""
    if mesh.fixed[h]:
        return LEFT
    x, y, t = mesh.x, mesh.y, mesh.twins[h]
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    # The sine of the sum of the angles at k and m, and the areas of the triangles kim and mjk.
    ax, ay, bx, by = x[h] - x[ki], y[h] - y[ki], x[t] - x[ki], y[t] - y[ki]
    cx, cy, dx, dy = x[t] - x[mj], y[t] - y[mj], x[h] - x[mj], y[h] - y[mj]
    ex, ey = x[mj] - x[ki], y[mj] - y[ki]
    aa, bb, cc, dd, ee = ax**2 + ay**2, bx**2 + by**2, cx**2 + cy**2, dx**2 + dy**2, ex**2 + ey**2
    sine = (ax * by - ay * bx) * (cx * dx + cy * dy) + (ax * bx + ay * by) * (cx * dy - cy * dx)
    if sine >= -_T.straight * np.sqrt(aa * bb * cc * dd):
        return LEFT
    if not (ax * ey - ay * ex > _D.thin * max(aa, dd, ee) and ex * by - ey * bx > _D.thin * max(bb, cc, ee)):
        return BLOCKED
    for start, to in ((jk, t), (im, h), (mj, jk), (ki, im)):
        _copy(start, to, mesh, rule)
    swap_diagonals(h, mesh.corners, mesh.twins)
    _join(jk, im, mesh, rule)
    for side in (h, ki, t, mj):
        rule.leaving[mesh.corners[side]] = side
    return FLIPPED
