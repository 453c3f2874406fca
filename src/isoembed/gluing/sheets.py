"""Faces joined side by side in the plane to sheets that do not overlap."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.gluing.faces import Faces
from isoembed.intrinsic.plane import folds, meet
from isoembed.kernel import kernel


@kernel
def joined(faces: Faces, order: Indices) -> tuple[Floats, Indices, Indices]:
    """Join faces along sides, where the sheets that are there do not overlap or touch then.

    The outlines of two sheets, turned so that they have one side in common and lie on different sides of it,
    do not meet elsewhere: then the sheets have nothing else in common, and the outline of both together is
    simple again.

    Parameters
    ----------
    faces : Faces
        Of the size of 1 at most, all in a row.
    order : ndarray of int
        Sides, in the order in which it is tried to join the faces beside them.

    Returns
    -------
    points : ndarray, shape (S, 2)
        Where the sides begin in the plane of their sheet.
    after : ndarray of int, shape (S,)
        The next side on the outline of the sheet; -1 for those inside.
    sheets : ndarray of int, shape (S,)
        A side that is the same for all sides of a sheet.
    """
    first, points, twins = faces.first, faces.points.copy(), faces.twins
    S = len(points)
    after, before, following = np.empty(S, np.int64), np.empty(S, np.int64), np.empty(S, np.int64)
    sheets, rest, size = np.empty(S, np.int64), np.empty(S, np.int64), np.zeros(S, np.int64)
    for f in range(len(first) - 1):
        low, high = first[f], first[f + 1]
        size[low] = high - low
        for s in range(low, high):
            nxt = s + 1 if s + 1 < high else low
            after[s], following[s], before[nxt] = nxt, nxt, s
            sheets[s] = low
            rest[s] = s + 1 if s + 1 < high else -1  # of the sides of the sheet
    tail = sheets.copy()  # the last of them, by sheet
    for f in range(len(first) - 1):
        tail[first[f]] = first[f + 1] - 1
    moved = np.empty((S, 2))
    for s in order:
        t = twins[s]
        if sheets[s] == sheets[t]:
            continue
        if size[sheets[s]] < size[sheets[t]]:
            s, t = t, s
        turn = _motion(points[t], points[following[t]], points[following[s]], points[s])
        if not _apart(s, t, turn, points, after, following, moved):
            continue
        stay, go = sheets[s], sheets[t]
        u = go
        while u >= 0:
            points[u] = _put(points[u], turn)
            sheets[u] = stay
            u = rest[u]
        rest[tail[stay]], tail[stay] = go, tail[go]
        size[stay] += size[go]
        p, q, u, v = before[s], after[s], before[t], after[t]
        after[p], before[v] = v, p
        after[u], before[q] = q, u
        after[s] = after[t] = -1
    return points, after, sheets


@kernel
def _motion(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """The motion of the plane that takes the segment from a to b to that from c to d."""
    x, y, u, v = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    cosine, sine = x * u + y * v, x * v - y * u
    norm = np.hypot(cosine, sine)
    cosine, sine = cosine / norm, sine / norm
    x, y = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    shift_x = (c[0] + d[0]) / 2 - (cosine * x - sine * y)
    shift_y = (c[1] + d[1]) / 2 - (sine * x + cosine * y)
    return np.array([cosine, sine, shift_x, shift_y])


@kernel
def _put(point: Floats, motion: Floats) -> Floats:
    cosine, sine, x, y = motion
    return np.array([cosine * point[0] - sine * point[1] + x, sine * point[0] + cosine * point[1] + y])


@kernel
def _apart(
    s: int, t: int, motion: Floats, points: Floats, after: Indices, following: Indices, moved: Floats
) -> bool:
    """Whether the outlines of s and t, this moved so that it lies on s, meet nowhere else.

    The sides after t begin where s begins, and the last one ends where s ends.
    """
    n, u = 0, after[t]
    while u != t:
        moved[n] = _put(points[u], motion)
        n += 1
        u = after[u]
    moved[0], moved[n] = points[s], points[following[s]]
    low, high = moved[0].copy(), moved[0].copy()
    for k in range(1, n + 1):
        low, high = np.minimum(low, moved[k]), np.maximum(high, moved[k])
    v = after[s]
    while v != s:
        c, d = points[v], points[following[v]]
        w = after[v]
        if (
            max(c[0], d[0]) >= low[0]
            and min(c[0], d[0]) <= high[0]
            and max(c[1], d[1]) >= low[1]
            and min(c[1], d[1]) <= high[1]
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
