"""Straight lines across triangles, which are unfolded one after another into the plane.

The line starts at the origin and runs along the positive x axis.  The triangle that it is in is known by the
half-edge through which it leaves, from a lower to an upper corner, and by where its three corners lie:
``(out, lower x, y, upper x, y, third x, y)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, following, preceding, third_corner
from isoembed.intrinsic.kernel import kernel
from isoembed.intrinsic.trigonometry import apex
from isoembed.thresholds import compiled, threshold

State = tuple[int, float, float, float, float, float, float]


@dataclass(frozen=True)
class TracingThresholds:
    """Thresholds of straight lines across triangles."""

    longest: int = threshold(
        10**6, "triangles", "A line may cross so many more than there are: round a needle."
    )
    astray: float = threshold(1e-6, "path lengths", "A path that misses its end by more went elsewhere.")


TRACING = TracingThresholds()
_T = compiled(TRACING)


@njit(cache=True, inline="always")
def modulo(angle: float, total: float) -> float:
    """The angle less whole turns, from 0 to the total angle."""
    return angle - np.floor(angle / total) * total


@kernel
def sector(h: int, direction: float, total: float, mesh: HalfEdges) -> tuple[int, float]:
    """Triangle into which a direction points.

    Parameters
    ----------
    h : int
        Any half-edge that leaves the vertex; the search goes counterclockwise from it.
    direction : float
    total : float
        The angle around the vertex.
    mesh : HalfEdges

    Returns
    -------
    int, float
        The half-edge next clockwise of the direction, and the angle from it to the direction.
    """
    offset = modulo(direction - mesh.directions[h], total)
    while True:
        ahead = mesh.twins[preceding(h)]
        nearer = modulo(direction - mesh.directions[ahead], total)
        if not nearer < offset:
            return h, offset
        h, offset = ahead, nearer


@kernel
def from_corner(h: int, offset: float, lengths: Floats) -> State:
    """The line that starts at a vertex, at an angle from a half-edge into its triangle."""
    into = preceding(h)
    ahead = corner_angle(h, lengths) - offset
    return (
        following(h),
        lengths[h] * np.cos(offset),
        -lengths[h] * np.sin(offset),
        lengths[into] * np.cos(ahead),
        lengths[into] * np.sin(ahead),
        0.0,
        0.0,
    )


@kernel
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


@kernel
def crossed(state: State, mesh: HalfEdges) -> State:
    """The line one triangle on."""
    out, lx, ly, ux, uy, _, _ = state
    g = mesh.twins[out]
    x, y = third_corner(g, ux, uy, lx, ly, mesh.lengths)
    if y > 0:
        return following(g), lx, ly, x, y, ux, uy
    return preceding(g), x, y, ux, uy, lx, ly


@kernel
def reaches(state: State, length: float) -> bool:
    """Whether the line is still in its triangle at this distance from its start."""
    _, lx, ly, ux, uy, _, _ = state
    return (uy - ly) * (lx - length) >= (ux - lx) * ly


@kernel
def straight(state: State, length: float, mesh: HalfEdges) -> State:
    """Follow a line over a distance; ``out`` is -1 if that leads across absurdly many triangles."""
    for _ in range(mesh.twins.size + _T.longest):
        if reaches(state, length):
            return state
        state = crossed(state, mesh)
    _, lx, ly, ux, uy, tx, ty = state
    return -1, lx, ly, ux, uy, tx, ty
