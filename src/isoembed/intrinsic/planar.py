"""New vertices in flat polygons, triangulated well."""

import math
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.chart import motion, moved, toward, turn_at
from isoembed.intrinsic.delaunay import (
    BLOCKED,
    FLIPPED,
    LEFT,
    attempts,
    push,
    restore_delaunay,
)
from isoembed.intrinsic.flips import swap_diagonals
from isoembed.intrinsic.halfedges import edges_between, following, glue, preceding
from isoembed.intrinsic.polygons import Polygons
from isoembed.intrinsic.trigonometry import cross, dot, from_frame, norm
from isoembed.kernel import kernel

OUTSIDE = 1e-9  # side lengths: a point farther outside of a face is searched for in all
ON_SIDE = 1e-11  # longest sides: height at which a vertex is put on a side that is not to be flipped
NEAR_SIDE = 1e-6  # side lengths: detour by way of a vertex that is put on another side


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
    sizes : ndarray, shape (number of polygons,)
        The longest side of each polygon, or of a triangle in it.
    simple : bool
        Whether flips are to join no two vertices that are joined already.
    """

    kept: Mask
    frames: Indices
    axes: Floats
    leaving: Indices
    sizes: Floats
    simple: bool


@kernel
def insert(
    v: int, p: complex, start: int, new: int, polygons: Polygons, marks: Marks, stack: Indices
) -> None:
    """Insert a vertex into a polygon.

    Parameters
    ----------
    v : int
    p : complex
        Where it lies.
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
    f = face_at(p, start, polygons, new // 3)
    s = _side_at(p, f, polygons, marks.sizes[polygons.cells[f]])
    if s < 0:
        g = f
        _split_face(v, p, 3 * f, new, polygons, marks)
    else:
        q, turn = _across(p, s, twins[s], polygons)
        marks.axes[new + 3] = marks.axes[new] + turn
        _split_side(v, p, s, new, polygons, marks)
        t = twins[s]  # which may have been moved: both can be sides of one face
        g = t // 3
        _split_side(v, q, t, new + 3, polygons, marks)
        glue(twins[t], new + 3, twins)
        glue(t, new, twins)
    for first in (3 * f, 3 * g, new, new + 3):
        for h in range(first, first + 3):
            marks.leaving[polygons.corners[h]] = h
            push(h, stack, twins)
    restore_delaunay(stack, polygons, marks)


@kernel
def face_at(p: complex, start: int, polygons: Polygons, n: int) -> int:
    """Face of a polygon in which a point lies, or nearly so, of n faces; the search begins at another."""
    f, came = start, -1
    for _ in range(n):
        go, least = -1, 0.0
        for h in range(3 * f, 3 * f + 3):
            distance = _distance(p, h, polygons)
            if h != came and not polygons.fixed[h] and distance < least:
                go, least = h, distance
        if go < 0:
            break
        came = polygons.twins[go]
        f = came // 3
    best = _depth(p, f, polygons)
    if best < -OUTSIDE:  # led astray: try all
        for g in range(n):
            if polygons.cells[g] == polygons.cells[start]:
                depth = _depth(p, g, polygons)
                if depth > best:
                    f, best = g, depth
    return f


@kernel
def _distance(p: complex, h: int, polygons: Polygons) -> float:
    """Signed distance of a point from the line of a half-edge, positive inside, over the length of that."""
    side, arm = _seen(p, h, polygons)
    return cross(side, arm) / dot(side, side)


@kernel
def _seen(p: complex, h: int, polygons: Polygons) -> tuple[complex, complex]:
    """The end of a half-edge and a point, both as seen from its start."""
    z, k = polygons.z, polygons.curvature
    return toward(z[h], z[following(h)], k), toward(z[h], p, k)


@kernel
def _depth(p: complex, f: int, polygons: Polygons) -> float:
    h = 3 * f
    return min(_distance(p, h, polygons), _distance(p, h + 1, polygons), _distance(p, h + 2, polygons))


@kernel
def _side_at(p: complex, f: int, polygons: Polygons, size: float) -> int:
    """The half-edge of a face that is to be split by a point in it; -1 if the point is well inside."""
    fixed = polygons.fixed
    least, s = 1.0, -1
    for h in range(3 * f, 3 * f + 3):
        side, arm = _seen(p, h, polygons)
        height = cross(side, arm) / dot(side, side)
        if fixed[h]:
            # It comes first: a point on it that is put on another is never put on it.
            share = height * norm(side) / (ON_SIDE * size) - 1
            if share >= 0:
                continue
        else:
            foot = dot(arm, side) / dot(side, side)
            detour = 0.0
            if height > 0:
                for along in (foot, 1 - foot):
                    way = np.hypot(along, height)
                    detour += height * height / (way + along) if along > 0 else way - along
            share = detour / NEAR_SIDE
        if share < least:
            least, s = share, h
    if s >= 0:
        t = polygons.twins[s]
        q, _ = _across(p, s, t, polygons)
        if not (_cuts(p, s, polygons) and _cuts(q, t, polygons)):
            return -1
    return s


@kernel
def _across(p: complex, s: int, t: int, polygons: Polygons) -> tuple[complex, float]:
    """A point near a side in the coordinates of the face across, and by what angle to these the axes turn."""
    z, start, k = polygons.z, polygons.z[following(t)], polygons.curvature
    if k != 0:
        turn, shift = motion(start, z[t], z[s], z[following(s)], k)
        return moved(p, turn, shift, k), -turn_at(p, turn, shift, k)
    here, there = z[following(s)] - z[s], z[t] - start
    size = dot(here, here)
    c, d = dot(there, here) / size, cross(here, there) / size
    return from_frame(start, p - z[s], c, d), -math.atan2(d, c)


@kernel
def _cuts(p: complex, s: int, polygons: Polygons) -> bool:
    """Whether a point on a side and the corner across make two triangles of which neither is turned over."""
    z, k = polygons.z, polygons.curvature
    tip = z[preceding(s)]
    arm = toward(tip, p, k)
    return cross(toward(tip, z[s], k), arm) > 0 and cross(arm, toward(tip, z[following(s)], k)) > 0


@kernel
def _split_face(v: int, p: complex, a: int, new: int, polygons: Polygons, marks: Marks) -> None:
    """Join a vertex to the corners of the face of half-edge a."""
    b, c = following(a), preceding(a)
    m, n = new, new + 3
    polygons.cells[m // 3] = polygons.cells[n // 3] = polygons.cells[a // 3]
    for h, to in ((b, m), (c, n)):
        _copy(h, to, polygons, marks)
        glue(to, polygons.twins[h], polygons.twins)
    for away, back, start in ((c, n + 1, a), (m + 2, b, m), (n + 2, m + 1, n)):
        _copy(start, back, polygons, marks)
        _set_corner(away, v, p, new, polygons, marks)
        _join(away, back, polygons, marks)


@kernel
def _split_side(v: int, p: complex, s: int, m: int, polygons: Polygons, marks: Marks) -> None:
    """Put a vertex on half-edge s and join it to the corner across; its second part m is not glued."""
    a, b = following(s), preceding(s)
    polygons.cells[m // 3] = polygons.cells[s // 3]
    for h, to in ((a, m + 1), (b, m + 2), (s, m)):
        _copy(h, to, polygons, marks)
    glue(m + 1, polygons.twins[a], polygons.twins)
    for away in (a, m):
        _set_corner(away, v, p, m, polygons, marks)
    _join(a, m + 2, polygons, marks)


@kernel
def _copy(h: int, to: int, polygons: Polygons, marks: Marks) -> None:
    """Copy all that is known of a half-edge but its twin."""
    polygons.corners[to], polygons.z[to], polygons.fixed[to] = (
        polygons.corners[h],
        polygons.z[h],
        polygons.fixed[h],
    )
    marks.kept[to], marks.frames[to] = marks.kept[h], marks.frames[h]


@kernel
def _set_corner(h: int, v: int, p: complex, frame: int, polygons: Polygons, marks: Marks) -> None:
    polygons.corners[h], polygons.z[h], marks.frames[h] = v, p, frame


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
    z, t, curvature = mesh.z, mesh.twins[h], mesh.curvature
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    i, j, k, m = z[h], z[t], z[ki], z[mj]
    if curvature != 0:  # seen from k, where lines from there are straight; circles are circles
        i, j, m, k = toward(k, i, curvature), toward(k, j, curvature), toward(k, m, curvature), 0j
    a, b, c, d, e = i - k, j - k, j - m, i - m, m - k
    aa, bb, cc, dd, ee = dot(a, a), dot(b, b), dot(c, c), dot(d, d), dot(e, e)
    sine = cross(a, b) * dot(c, d) + dot(a, b) * cross(c, d)  # of the sum of the angles at k and m
    if sine >= -1e-9 * np.sqrt(aa * bb * cc * dd):  # excess over pi of two angles, in radians, that is left
        return LEFT
    # coordinates do not hold thinner triangles
    if not (cross(a, e) > 1e-14 * max(aa, dd, ee) and cross(e, b) > 1e-14 * max(bb, cc, ee)):
        return BLOCKED
    if rule.simple and edges_between(ki, mesh.corners[mj], mesh.corners, mesh.twins) > 0:
        return BLOCKED
    for start, to in ((jk, t), (im, h), (mj, jk), (ki, im)):
        _copy(start, to, mesh, rule)
    swap_diagonals(h, mesh.corners, mesh.twins)
    _join(jk, im, mesh, rule)
    for side in (h, ki, t, mj):
        rule.leaving[mesh.corners[side]] = side
    return FLIPPED
