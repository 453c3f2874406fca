# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled overlap tests of planar outlines, and growth of sheets face by face."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Int, Real
from cython.cimports.isoembed.intrinsic.ear_loops import turn
from cython.cimports.libc.math import hypot

DIRECTIONS = 45  # in a right angle


@cython.cfunc
@cython.exceptval(check=False)
def _turn(a: ConstReal[::1], b: ConstReal[::1], c: ConstReal[::1]) -> Real:
    return turn(a[0], a[1], b[0], b[1], c[0], c[1])


@cython.cfunc
@cython.exceptval(check=False)
def meet(a: ConstReal[::1], b: ConstReal[::1], c: ConstReal[::1], d: ConstReal[::1]) -> cython.bint:
    """Whether the segments from a to b and from c to d touch or cross, up to rounding."""
    if max(a[0], b[0]) < min(c[0], d[0]) or max(c[0], d[0]) < min(a[0], b[0]):
        return False
    if max(a[1], b[1]) < min(c[1], d[1]) or max(c[1], d[1]) < min(a[1], b[1]):
        return False
    return _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0


@cython.cfunc
@cython.exceptval(check=False)
def folds(a: ConstReal[::1], b: ConstReal[::1], c: ConstReal[::1]) -> cython.bint:
    """Whether the segment from b to c reverses along the segment from a to b."""
    if (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) >= 0:
        return False
    return _turn(a, b, c) == 0


def joined(faces, order: ConstInt[::1], most: Int, room: ConstReal[::1]):
    """Join faces along sides as long as the sheets do not overlap or touch.

    Two sheets are placed on different sides of a common side.  If their outlines do not meet elsewhere, the
    sheets have nothing else in common, and the outline of their union is simple.

    Parameters
    ----------
    faces : Faces
        Faces, scaled to a size of at most 1.
    order : ndarray of int
        Sides in the order of the attempts to join the adjacent faces.
    most : int
        Largest number of faces to which a face is joined.
    room : ndarray, shape (2,)
        Width and height of a rectangle that contains each sheet of several faces; infinite without limit.

    Returns
    -------
    points : ndarray, shape (S, 2)
        Start of each side in the plane of its sheet.
    after : ndarray of int, shape (S,)
        Next side on the outline of the sheet; -1 for interior sides.
    sheets : ndarray of int, shape (S,)
        Representative side, common to all sides of a sheet.
    """
    first: ConstInt[::1] = faces.first
    twins: ConstInt[::1] = faces.twins
    points: Real[:, ::1] = faces.points.copy()
    t: Int
    u: Int
    v: Int
    S = points.shape[0]
    after: Int[::1] = np.empty(S, np.int64)
    before: Int[::1] = np.empty(S, np.int64)
    following: Int[::1] = np.empty(S, np.int64)
    sheets: Int[::1] = np.empty(S, np.int64)
    rest: Int[::1] = np.empty(S, np.int64)
    size: Int[::1] = np.zeros(S, np.int64)
    owner: Int[::1] = np.empty(S, np.int64)
    joints: Int[::1] = np.zeros(first.shape[0], np.int64)
    for f in range(first.shape[0] - 1):
        low, high = first[f], first[f + 1]
        size[low] = high - low
        for s in range(low, high):
            nxt = s + 1 if s + 1 < high else low
            after[s], following[s], before[nxt] = nxt, nxt, s
            sheets[s], owner[s] = low, f
            rest[s] = s + 1 if s + 1 < high else -1  # linked list of the sides of each sheet
    tail: Int[::1] = np.array(sheets)  # last side of each list, by sheet
    for f in range(first.shape[0] - 1):
        tail[first[f]] = first[f + 1] - 1
    moved: Real[:, ::1] = np.empty((S, 2))
    angles = np.arange(DIRECTIONS) * (np.pi / 2 / DIRECTIONS)
    compass: Real[:, ::1] = np.column_stack([np.cos(angles), np.sin(angles)])
    area: Real[::1] = np.zeros(S)
    most_area: Real = room[0] * room[1]
    for f in range(first.shape[0] - 1):
        low = first[f]
        for s in range(low, first[f + 1]):
            nxt = following[s]
            area[low] += (points[s, 0] * points[nxt, 1] - points[s, 1] * points[nxt, 0]) / 2
    bounded: cython.bint = min(room[0], room[1]) < np.inf
    turning: Real[::1] = np.empty(4)
    for side in order:
        s = side
        t = twins[s]
        if sheets[s] == sheets[t] or joints[owner[s]] >= most or joints[owner[t]] >= most:
            continue
        if size[sheets[s]] < size[sheets[t]]:
            s, t = t, s
        _set_motion(points[t], points[following[t]], points[following[s]], points[s], turning)
        if area[sheets[s]] + area[sheets[t]] > most_area:
            continue
        if not _apart(s, t, turning, points, after, following, moved):
            continue
        if bounded and not _fits(s, t, points, after, following, moved, compass, room):
            continue
        stay, go = sheets[s], sheets[t]
        u = go
        while u >= 0:
            _put(points, u, turning, points, u)
            sheets[u] = stay
            u = rest[u]
        rest[tail[stay]], tail[stay] = go, tail[go]
        size[stay] += size[go]
        area[stay] += area[go]
        p, q, u, v = before[s], after[s], before[t], after[t]
        after[p], before[v] = v, p
        after[u], before[q] = q, u
        after[s] = after[t] = -1
        joints[owner[s]] += 1
        joints[owner[t]] += 1
    return np.asarray(points), np.asarray(after), np.asarray(sheets)


@cython.cfunc
@cython.exceptval(check=False)
def _set_motion(
    a: ConstReal[::1], b: ConstReal[::1], c: ConstReal[::1], d: ConstReal[::1], motion: Real[::1]
) -> cython.void:
    """Compute the rigid motion that takes the segment from a to b to that from c to d."""
    x, y, u, v = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    cosine, sine = x * u + y * v, x * v - y * u
    norm = hypot(cosine, sine)
    cosine, sine = cosine / norm, sine / norm
    x, y = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    motion[0], motion[1] = cosine, sine
    motion[2] = (c[0] + d[0]) / 2 - (cosine * x - sine * y)
    motion[3] = (c[1] + d[1]) / 2 - (sine * x + cosine * y)


@cython.cfunc
@cython.exceptval(check=False)
def _put(points: Real[:, ::1], u: Int, motion: Real[::1], target: Real[:, ::1], k: Int) -> cython.void:
    """Move a point."""
    x, y = points[u, 0], points[u, 1]
    target[k, 0] = motion[0] * x - motion[1] * y + motion[2]
    target[k, 1] = motion[1] * x + motion[0] * y + motion[3]


@cython.cfunc
@cython.exceptval(check=False)
def _apart(
    s: Int,
    t: Int,
    motion: Real[::1],
    points: Real[:, ::1],
    after: ConstInt[::1],
    following: ConstInt[::1],
    moved: Real[:, ::1],
) -> cython.bint:
    """Whether the outlines of s and t meet only in s and t, after t is moved to s.

    The sides after t start where s starts, and the last one ends where s ends.
    """
    left: Real
    right: Real
    bottom: Real
    top: Real
    n: Int = 0
    u = after[t]
    while u != t:
        _put(points, u, motion, moved, n)
        n += 1
        u = after[u]
    for axis in range(2):
        moved[0, axis], moved[n, axis] = points[s, axis], points[following[s], axis]
    left, right = moved[0, 0], moved[0, 0]
    bottom, top = moved[0, 1], moved[0, 1]
    for k in range(1, n + 1):
        left, right = min(left, moved[k, 0]), max(right, moved[k, 0])
        bottom, top = min(bottom, moved[k, 1]), max(top, moved[k, 1])
    v = after[s]
    while v != s:
        c, d = points[v], points[following[v]]
        w = after[v]
        if (
            max(c[0], d[0]) >= left
            and min(c[0], d[0]) <= right
            and max(c[1], d[1]) >= bottom
            and min(c[1], d[1]) <= top
        ):
            for k in range(n):
                a, b = moved[k], moved[k + 1]
                if w == s and k == 0:
                    if folds(c, d, b):
                        return False
                elif v == after[s] and k == n - 1:
                    if folds(a, b, d):
                        return False
                elif meet(a, b, c, d):
                    return False
        v = w
    return True


@cython.cfunc
def _fits(
    s: Int,
    t: Int,
    points: Real[:, ::1],
    after: ConstInt[::1],
    following: ConstInt[::1],
    moved: Real[:, ::1],
    compass: Real[:, ::1],
    room: ConstReal[::1],
) -> cython.bint:
    """Whether the joined outlines of s and t fit into a rectangle at some angle to side s.

    The points after t have been moved by `_apart`.
    """
    n: Int = 0
    u = after[t]
    while u != t:
        n += 1
        u = after[u]
    x, y = points[following[s], 0] - points[s, 0], points[following[s], 1] - points[s, 1]
    norm = hypot(x, y)
    x, y = x / norm, y / norm
    diagonal = hypot(room[0], room[1])
    for k in range(compass.shape[0]):
        along_x, along_y = x * compass[k, 0] - y * compass[k, 1], x * compass[k, 1] + y * compass[k, 0]
        left = right = along_x * points[s, 0] + along_y * points[s, 1]
        bottom = top = along_x * points[s, 1] - along_y * points[s, 0]
        for j in range(1, n):
            p = along_x * moved[j, 0] + along_y * moved[j, 1]
            q = along_x * moved[j, 1] - along_y * moved[j, 0]
            left, right, bottom, top = min(left, p), max(right, p), min(bottom, q), max(top, q)
        v = after[s]
        while v != s:
            p = along_x * points[v, 0] + along_y * points[v, 1]
            q = along_x * points[v, 1] - along_y * points[v, 0]
            left, right, bottom, top = min(left, p), max(right, p), min(bottom, q), max(top, q)
            v = after[v]
        p, q = right - left, top - bottom
        if (p <= room[0] and q <= room[1]) or (p <= room[1] and q <= room[0]):
            return True
        if max(p, q) > diagonal:
            return False
    return False


def meeting(points: ConstReal[:, ::1], order: ConstInt[::1]):
    """First two sides that meet other than at a common corner; -1, -1 if there are none.

    Sides are sorted by their left ends, and each is compared with those that start before it ends.
    """
    n = points.shape[0]
    for k in range(n):
        i = order[k]
        a, b = points[i], points[(i + 1) % n]
        right = max(a[0], b[0])
        for m in range(k + 1, n):
            j = order[m]
            c, d = points[j], points[(j + 1) % n]
            if min(c[0], d[0]) > right:
                break
            if j == (i + 1) % n:
                if folds(a, b, d):
                    return i, j
            elif i == (j + 1) % n:
                if folds(c, d, b):
                    return i, j
            elif meet(a, b, c, d):
                return i, j
    return -1, -1
