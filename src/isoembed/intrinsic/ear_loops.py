# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled ear clipping of plane polygons, and constrained Delaunay flips inside them."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstReal, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.loops import Rule, preceding, swap_diagonals

SLACK = cython.declare(cython.double, 1e-12)  # relative tolerance of the Delaunay criterion
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule, as in `loops`
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)


@cython.cfunc
@cython.exceptval(check=False)
def turn(
    ax: cython.double,
    ay: cython.double,
    bx: cython.double,
    by: cython.double,
    cx: cython.double,
    cy: cython.double,
) -> cython.double:
    """Twice the signed area of triangle abc, positive if counterclockwise; 0 if within rounding.

    The coordinates are at most of order 1.
    """
    x, y = bx - ax, by - ay
    u, v = cx - ax, cy - ay
    area = x * v - y * u
    # collinear up to rounding
    return area if abs(area) > 2e-15 * (abs(x) + abs(y) + abs(u) + abs(v)) else 0.0


@cython.cfunc
@cython.exceptval(check=False)
def corner_turn(points: ConstReal[:, ::1], a: Int, b: Int, c: Int) -> Real:
    """`turn` of three of the points."""
    return turn(points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1])


def clip_ears(points: ConstReal[:, ::1], triangles: Int[:, ::1]):
    """Triangulate a simple polygon by ear clipping; return False if a triangle degenerates by rounding."""
    n = points.shape[0]
    after: Int[::1] = np.arange(1, n + 1) % n
    before: Int[::1] = np.arange(-1, n - 1) % n
    blunt: Flag[::1] = np.empty(n, dtype=np.bool_)  # angles of pi or more: only these can lie in an ear
    for k in range(n):
        blunt[k] = corner_turn(points, before[k], k, after[k]) <= 0
    suspects: Int[::1] = np.flatnonzero(blunt)
    count: Int = 0
    v: Int = 0
    refused: Int = 0
    while count < n - 3:
        if refused > n - count:
            return False
        a, b = before[v], after[v]
        if blunt[v] or not _empty(a, v, b, points, suspects, blunt):
            v = b
            refused += 1
            continue
        triangles[count, 0], triangles[count, 1], triangles[count, 2] = a, v, b
        count += 1
        refused = 0
        after[a], before[b] = b, a
        # angles only decrease
        blunt[a] = blunt[a] and corner_turn(points, before[a], a, after[a]) <= 0
        blunt[b] = blunt[b] and corner_turn(points, before[b], b, after[b]) <= 0
        v = after[b]  # skipping b avoids fans
    a, b = before[v], after[v]
    triangles[count, 0], triangles[count, 1], triangles[count, 2] = a, v, b
    return corner_turn(points, a, v, b) > 0


@cython.cfunc
@cython.exceptval(check=False)
def _empty(
    a: Int, v: Int, b: Int, points: ConstReal[:, ::1], suspects: Int[::1], blunt: Flag[::1]
) -> cython.bint:
    """Whether no other corner lies in the triangle or on its boundary."""
    for w in suspects:
        if not blunt[w] or w in (a, b):
            continue
        if (
            corner_turn(points, a, v, w) >= 0
            and corner_turn(points, v, b, w) >= 0
            and corner_turn(points, b, a, w) >= 0
        ):
            return False
    return True


@cython.cfunc
@cython.exceptval(check=False)
def _cotangent(points: ConstReal[:, ::1], i: Int, j: Int, k: Int) -> Real:
    """Cotangent of the angle at k."""
    x, y = points[i, 0] - points[k, 0], points[i, 1] - points[k, 1]
    u, v = points[j, 0] - points[k, 0], points[j, 1] - points[k, 1]
    return (x * u + y * v) / (x * v - y * u)


@cython.cclass
class Constrained(Rule):
    """Delaunay rule inside a polygon with corners (n, 2).

    The triangles are half-edge tables; ``twins`` of the outline are beyond the end of ``corners``.
    """

    corners: Int[::1]
    points: ConstReal[:, ::1]

    def __init__(self, corners, twins, points):
        self.corners, self.twins, self.points = corners, twins, points

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        # An edge is flipped if the sum of its opposite angles exceeds pi: the sum of their cotangents is
        # negative.
        corners, points, t = self.corners, self.points, self.twins[h]
        if t >= corners.shape[0]:
            return LEFT
        i, j, k, m = corners[h], corners[t], corners[preceding(h)], corners[preceding(t)]
        here, there = _cotangent(points, i, j, k), _cotangent(points, j, i, m)
        if here + there >= -SLACK * (abs(here) + abs(there)):
            return LEFT
        if corner_turn(points, m, j, k) <= 0 or corner_turn(points, k, i, m) <= 0:
            return BLOCKED
        swap_diagonals(h, corners, self.twins)
        return FLIPPED
