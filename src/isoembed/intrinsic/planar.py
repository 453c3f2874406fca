"""New vertices in the plane polygons that triangles form between edges that are kept, triangulated well.

Lengths alone would not do: to flip a triangle a thousand times longer than high loses three digits, and to
flip it again three more.  Here every corner of a triangle has coordinates, which no flip changes.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.intrinsic.flips import angle_between, following, preceding
from isoembed.intrinsic.local_delaunay import THIN, push
from isoembed.intrinsic.tracing import third_corner

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

STRAIGHT = 1e-9  # radians by which a corner of a polygon may seem reflex, and two angles more than pi
# How much longer the way along a side is by way of a vertex that is put on it, at most.  Two sides that are
# longer than the third by less than ON_SIDE make no triangle in floats; the vertex is 2e-8 of it off.  A side
# that may be flipped anyway is split early, which spares two thin triangles.
ON_SIDE, NEAR_SIDE = 1e-15, 1e-6


@njit(cache=True)
def lay_out(twins: Indices, lengths: Floats, kept: Mask) -> tuple[Indices, Floats, Floats, Mask]:
    """Unfold the triangles between kept edges into the plane.

    Returns
    -------
    ndarray of int, shape (F,)
        To which polygon a face belongs.
    ndarray, ndarray, shape (3F,)
        Coordinates of the corners, continuous in each polygon.
    ndarray of bool, shape (3F,)
        The half-edges between polygons.  Where the kept edges bound no convex polygons, each triangle is one.
    """
    n = twins.size // 3
    fixed = kept.copy()
    cells = _cells(twins, fixed)
    plane = _are_convex(cells, twins, lengths, fixed)
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
    return cells, x, y, fixed


@njit(cache=True)
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


@njit(cache=True)
def _are_convex(cells: Indices, twins: Indices, lengths: Floats, fixed: Mask) -> Mask:
    """Which cells are convex polygons, by number.

    A cell of n faces that hang together at n - 1 edges has no vertex inside and no hole; and if it has no
    reflex corner either, it does not overlap itself.
    """
    n = int(cells.max()) + 1
    inner = np.zeros(n, dtype=np.int64)
    size = np.zeros(n, dtype=np.int64)
    convex = np.ones(n, dtype=np.bool_)
    for h in range(twins.size):
        c = cells[h // 3]
        if h % 3 == 0:
            size[c] += 1
        if not fixed[h]:
            inner[c] += 1
        else:
            # The corner from this side counterclockwise to the one before it.
            angle = 0.0
            e = h
            for _ in range(twins.size):
                into = preceding(e)
                angle += angle_between(lengths[e], lengths[into], lengths[following(e)])
                if fixed[into]:
                    break
                e = twins[into]
            if angle > np.pi + STRAIGHT:
                convex[c] = False
    return convex & (inner == 2 * (size - 1))


@njit(cache=True)
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


@njit(cache=True)
def insert(
    v: int,
    px: float,
    py: float,
    axis: float,
    start: int,
    new: int,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    axes: Floats,
    kept: Mask,
    fixed: Mask,
    cells: Indices,
    leaving: Indices,
    stack: Indices,
    waiting: Mask,
) -> None:
    """Insert a vertex into a polygon.

    Parameters
    ----------
    v : int
    px, py, axis : float
        Its coordinates, and its direction that is the x axis.
    start : int
        A face of the polygon from which it is to be searched.
    new : int
        Six half-edges from here on are unused.
    corners, twins, x, y, frames, axes, kept, fixed, stack, waiting : ndarray, shape (3F,)
        The vertex at each corner and its coordinates; where in ``axes`` its direction that is the x axis is
        to be found; which half-edges are of kept edges or between polygons.
    cells : ndarray of int, shape (F,)
    leaving : ndarray of int, shape (V,)
    """
    f = face_at(px, py, start, twins, x, y, fixed, cells, new // 3)
    s = _side_at(px, py, f, twins, x, y, fixed)
    axes[new] = axis
    if s < 0:
        g = f
        _split_face(v, px, py, 3 * f, new, corners, twins, x, y, frames, kept, fixed, cells)
    else:
        qx, qy, turn = _across(px, py, s, twins[s], x, y)
        axes[new + 3] = axis + turn
        _split_side(v, px, py, s, new, corners, twins, x, y, frames, kept, fixed, cells)
        t = twins[s]
        g = t // 3
        _split_side(v, qx, qy, t, new + 3, corners, twins, x, y, frames, kept, fixed, cells)
        _glue(twins[t], new + 3, twins)
        _glue(t, new, twins)
    top = 0
    for first in (3 * f, 3 * g, new, new + 3):
        for h in range(first, first + 3):
            leaving[corners[h]] = h
            top = push(h, stack, top, waiting, twins)
    flip_to_delaunay(stack, top, waiting, corners, twins, x, y, frames, kept, fixed, leaving)


@njit(cache=True)
def face_at(
    px: float,
    py: float,
    start: int,
    twins: Indices,
    x: Floats,
    y: Floats,
    fixed: Mask,
    cells: Indices,
    n: int,
) -> int:
    """The face of a polygon in which a point lies, or nearly so, of n faces; the search begins at another."""
    f, came = start, -1
    for _ in range(n):
        go, least = -1, 0.0
        for h in range(3 * f, 3 * f + 3):
            distance = _distance(px, py, h, x, y)
            if h != came and not fixed[h] and distance < least:
                go, least = h, distance
        if go < 0:
            break
        came = twins[go]
        f = came // 3
    best = _depth(px, py, f, x, y)
    if best < -STRAIGHT:  # led astray: try all
        for g in range(n):
            if cells[g] == cells[start]:
                depth = _depth(px, py, g, x, y)
                if depth > best:
                    f, best = g, depth
    return f


@njit(cache=True)
def _distance(px: float, py: float, h: int, x: Floats, y: Floats) -> float:
    """Signed distance of a point from the line of a half-edge, positive inside, over the length of that."""
    e = following(h)
    u, v = x[e] - x[h], y[e] - y[h]
    return (u * (py - y[h]) - v * (px - x[h])) / (u * u + v * v)


@njit(cache=True)
def _depth(px: float, py: float, f: int, x: Floats, y: Floats) -> float:
    return min(
        _distance(px, py, 3 * f, x, y),
        _distance(px, py, 3 * f + 1, x, y),
        _distance(px, py, 3 * f + 2, x, y),
    )


@njit(cache=True)
def _side_at(px: float, py: float, f: int, twins: Indices, x: Floats, y: Floats, fixed: Mask) -> int:
    """The half-edge of a face that is to be split by a point in it; -1 if the point is well inside."""
    least, s = 1.0, -1
    for h in range(3 * f, 3 * f + 3):
        e = following(h)
        l = np.hypot(x[e] - x[h], y[e] - y[h])
        height = _distance(px, py, h, x, y)
        foot = ((px - x[h]) * (x[e] - x[h]) + (py - y[h]) * (y[e] - y[h])) / (l * l)
        detour = 0.0
        if height > 0:
            for along in (foot, 1 - foot):
                way = np.hypot(along, height)
                detour += height**2 / (way + along) if along > 0 else way - along
        # A side that may not be flipped comes first: a point on it that is put on another is never put on it.
        share = detour / ON_SIDE - 1 if fixed[h] else detour / NEAR_SIDE
        if share < least and not (fixed[h] and share >= 0):
            least, s = share, h
    if s >= 0:
        t = twins[s]
        qx, qy, _ = _across(px, py, s, t, x, y)
        if not (_cuts(px, py, s, x, y) and _cuts(qx, qy, t, x, y)):
            return -1
    return s


@njit(cache=True)
def _across(px: float, py: float, s: int, t: int, x: Floats, y: Floats) -> tuple[float, float, float]:
    """A point near a side in the coordinates of the face across, and by what angle to these the axes turn."""
    a, b = following(s), following(t)
    u, v = x[a] - x[s], y[a] - y[s]
    p, q = x[t] - x[b], y[t] - y[b]
    size = u * u + v * v
    c, d = (p * u + q * v) / size, (q * u - p * v) / size
    return (
        x[b] + c * (px - x[s]) - d * (py - y[s]),
        y[b] + c * (py - y[s]) + d * (px - x[s]),
        -np.arctan2(d, c),
    )


@njit(cache=True)
def _cuts(px: float, py: float, s: int, x: Floats, y: Floats) -> bool:
    """Whether a point on a side and the corner across make two triangles of which neither is turned over."""
    a, b = following(s), preceding(s)
    return (x[s] - x[b]) * (py - y[b]) > (y[s] - y[b]) * (px - x[b]) and (px - x[b]) * (y[a] - y[b]) > (
        py - y[b]
    ) * (x[a] - x[b])


@njit(cache=True)
def _split_face(
    v: int,
    px: float,
    py: float,
    a: int,
    new: int,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    kept: Mask,
    fixed: Mask,
    cells: Indices,
) -> None:
    """Join a vertex to the corners of the face of half-edge a."""
    b, c = following(a), preceding(a)
    m, n = new, new + 3
    cells[m // 3] = cells[n // 3] = cells[a // 3]
    _move(b, m, corners, twins, x, y, frames, kept, fixed)
    _move(c, n, corners, twins, x, y, frames, kept, fixed)
    for away, back, start in ((c, n + 1, a), (m + 2, b, m), (n + 2, m + 1, n)):
        _glue(away, back, twins)
        kept[away] = kept[back] = fixed[away] = fixed[back] = False
        corners[away], x[away], y[away], frames[away] = v, px, py, new
        corners[back], x[back], y[back], frames[back] = corners[start], x[start], y[start], frames[start]


@njit(cache=True)
def _split_side(
    v: int,
    px: float,
    py: float,
    s: int,
    m: int,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    kept: Mask,
    fixed: Mask,
    cells: Indices,
) -> None:
    """Put a vertex on half-edge s and join it to the corner across; its second part m is not glued."""
    a, b = following(s), preceding(s)
    cells[m // 3] = cells[s // 3]
    _move(a, m + 1, corners, twins, x, y, frames, kept, fixed)
    for away in (a, m):
        corners[away], x[away], y[away], frames[away] = v, px, py, m
    corners[m + 2], x[m + 2], y[m + 2], frames[m + 2] = corners[b], x[b], y[b], frames[b]
    kept[m], fixed[m] = kept[s], fixed[s]
    kept[a] = kept[m + 2] = fixed[a] = fixed[m + 2] = False
    _glue(a, m + 2, twins)


@njit(cache=True)
def _move(
    h: int,
    to: int,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    kept: Mask,
    fixed: Mask,
) -> None:
    """Give a half-edge another number."""
    corners[to], x[to], y[to], frames[to] = corners[h], x[h], y[h], frames[h]
    kept[to], fixed[to] = kept[h], fixed[h]
    _glue(to, twins[h], twins)


@njit(cache=True)
def _glue(g: int, h: int, twins: Indices) -> None:
    twins[g], twins[h] = h, g


@njit(cache=True)
def flip_to_delaunay(
    stack: Indices,
    top: int,
    waiting: Mask,
    corners: Indices,
    twins: Indices,
    x: Floats,
    y: Floats,
    frames: Indices,
    kept: Mask,
    fixed: Mask,
    leaving: Indices,
) -> None:
    """Flip edges inside polygons to Delaunay, beginning with those on a stack; arguments as of `insert`."""
    limit = 100 * corners.size + 1000
    while top > 0:
        top -= 1
        h = stack[top]
        waiting[h] = False
        if fixed[h] or limit == 0:
            continue
        t = twins[h]
        jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
        # The sine of the sum of the angles at k and m, and the areas of the triangles kim and mjk.
        ax, ay, bx, by = x[h] - x[ki], y[h] - y[ki], x[t] - x[ki], y[t] - y[ki]
        cx, cy, dx, dy = x[t] - x[mj], y[t] - y[mj], x[h] - x[mj], y[h] - y[mj]
        ex, ey = x[mj] - x[ki], y[mj] - y[ki]
        aa, bb, cc, dd, ee = ax**2 + ay**2, bx**2 + by**2, cx**2 + cy**2, dx**2 + dy**2, ex**2 + ey**2
        sine = (ax * by - ay * bx) * (cx * dx + cy * dy) + (ax * bx + ay * by) * (cx * dy - cy * dx)
        if sine >= -STRAIGHT * np.sqrt(aa * bb * cc * dd):
            continue
        if not (ax * ey - ay * ex > THIN * max(aa, dd, ee) and ex * by - ey * bx > THIN * max(bb, cc, ee)):
            continue
        limit -= 1
        _move(jk, t, corners, twins, x, y, frames, kept, fixed)
        _move(im, h, corners, twins, x, y, frames, kept, fixed)
        _glue(jk, im, twins)
        kept[jk] = kept[im] = fixed[jk] = fixed[im] = False
        corners[jk], x[jk], y[jk], frames[jk] = corners[mj], x[mj], y[mj], frames[mj]
        corners[im], x[im], y[im], frames[im] = corners[ki], x[ki], y[ki], frames[ki]
        for side in (h, ki, t, mj):
            leaving[corners[side]] = side
            top = push(side, stack, top, waiting, twins)
