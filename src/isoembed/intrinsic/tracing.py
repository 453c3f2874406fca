"""Straight lines across triangles, which are unfolded one after another into the plane.

The line starts at the origin and runs along the positive x axis.  The triangle that it is in is known by the
half-edge through which it leaves, from a lower to an upper corner, and by where its three corners lie:
``(out, lower x, y, upper x, y, third x, y)``.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.intrinsic.flips import angle_between, apex, following, preceding

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
State = tuple[int, float, float, float, float, float, float]

LONGEST = 10**6  # triangles that a line may cross beyond the number that there are: a needle is wound around


@njit(cache=True, inline="always")
def modulo(angle: float, total: float) -> float:
    """The angle less whole turns, from 0 to the total angle."""
    return angle - np.floor(angle / total) * total


@njit(cache=True)
def total_angle(h: int, twins: Indices, lengths: Floats) -> float:
    """The sum of the angles at the vertex that a half-edge leaves."""
    start = h
    total = 0.0
    while True:
        into = preceding(h)
        total += angle_between(lengths[h], lengths[into], lengths[following(h)])
        h = twins[into]
        if h == start:
            return total


@njit(cache=True)
def sector(h: int, direction: float, total: float, twins: Indices, directions: Floats) -> tuple[int, float]:
    """The triangle into which a direction points.

    Parameters
    ----------
    h : int
        Any half-edge that leaves the vertex; the search goes counterclockwise from it.
    direction : float
    total : float
        The angle around the vertex.
    twins, directions : ndarray, shape (3F,)

    Returns
    -------
    int, float
        The half-edge next clockwise of the direction, and the angle from it to the direction.
    """
    offset = modulo(direction - directions[h], total)
    while True:
        ahead = twins[preceding(h)]
        nearer = modulo(direction - directions[ahead], total)
        if not nearer < offset:
            return h, offset
        h, offset = ahead, nearer


@njit(cache=True)
def from_corner(h: int, offset: float, lengths: Floats) -> State:
    """The line that starts at a vertex, at an angle from a half-edge into its triangle."""
    out, into = following(h), preceding(h)
    ahead = angle_between(lengths[h], lengths[into], lengths[out]) - offset
    return (
        out,
        lengths[h] * np.cos(offset),
        -lengths[h] * np.sin(offset),
        lengths[into] * np.cos(ahead),
        lengths[into] * np.sin(ahead),
        0.0,
        0.0,
    )


@njit(cache=True)
def from_inside(f: int, x: float, y: float, angle: float, lengths: Floats) -> State:
    """The line that starts in a face, at coordinates and at an angle from the first half-edge of the face."""
    l = lengths[3 * f]
    u, v = apex(l, lengths[3 * f + 1], lengths[3 * f + 2])
    c, s = np.cos(angle), np.sin(angle)
    p, q = np.empty(3), np.empty(3)
    for k, (a, b) in enumerate(((-x, -y), (l - x, -y), (u - x, v - y))):
        p[k], q[k] = c * a + s * b, c * b - s * a
    k = -1
    for c in range(3):
        if q[c] < 0 <= q[(c + 1) % 3]:
            k = c
    if k < 0:  # along a side, and rounding puts all corners above or all below: it leaves at the corner ahead
        for c in range(3):
            if k < 0 or p[c] * np.hypot(p[k], q[k]) > p[k] * np.hypot(p[c], q[c]):
                k = c
        if q.max() <= 0:
            k = (k + 2) % 3
    i, j = (k + 1) % 3, (k + 2) % 3
    return 3 * f + k, p[k], q[k], p[i], q[i], p[j], q[j]


@njit(cache=True)
def third_corner(h: int, px: float, py: float, qx: float, qy: float, lengths: Floats) -> tuple[float, float]:
    """Where the third corner of a triangle lies, to the left of half-edge h from p to q."""
    l = lengths[h]
    x, y = apex(l, lengths[following(h)], lengths[preceding(h)])
    x, y = x / l, y / l
    return px + x * (qx - px) - y * (qy - py), py + x * (qy - py) + y * (qx - px)


@njit(cache=True)
def crossed(state: State, twins: Indices, lengths: Floats) -> State:
    """The line one triangle on."""
    out, lx, ly, ux, uy, _, _ = state
    g = twins[out]
    x, y = third_corner(g, ux, uy, lx, ly, lengths)
    if y > 0:
        return following(g), lx, ly, x, y, ux, uy
    return preceding(g), x, y, ux, uy, lx, ly


@njit(cache=True)
def reaches(state: State, length: float) -> bool:
    """Whether the line is still in its triangle at this distance from its start."""
    _, lx, ly, ux, uy, _, _ = state
    return (uy - ly) * (lx - length) >= (ux - lx) * ly


@njit(cache=True)
def straight(state: State, length: float, twins: Indices, lengths: Floats) -> State:
    """Follow a line over a distance; ``out`` is -1 if that leads across absurdly many triangles."""
    for _ in range(twins.size + LONGEST):
        if reaches(state, length):
            return state
        state = crossed(state, twins, lengths)
    _, lx, ly, ux, uy, tx, ty = state
    return -1, lx, ly, ux, uy, tx, ty
