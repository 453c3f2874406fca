"""Straight lines across triangles, which are unfolded one after another in a `chart`.

The line starts at the origin and runs along the positive x axis.  The triangle that it is in is known by the
half-edge through which it leaves, from a lower to an upper corner, and by the motion that takes the frame of
its polygon to that of the line: ``(out, turn, shift)``, so that in the plane corner h lies at
``turn z[h] + shift``.
"""

import numpy as np

from isoembed.intrinsic.chart import motion, moved, toward
from isoembed.intrinsic.halfedges import HalfEdges, following, preceding
from isoembed.intrinsic.polygons import Polygons
from isoembed.intrinsic.trigonometry import dot, norm, polar
from isoembed.kernel import kernel
from isoembed.space.trigonometry import cs, sn

State = tuple[int, complex, complex]


EXTRA_CROSSINGS = 10**6  # a line may cross so many more triangles than there are: round a needle


@kernel(inline="always")
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


# A call would copy all of the named tuple: compiled into its callers, though the formulas of curved space
# make it longer than what is by itself.
@kernel(forceinline=True)
def place(h: int, state: State, polygons: Polygons) -> complex:
    """Where a corner of the triangle lies."""
    _, turn, shift = state
    if polygons.curvature == 0:
        return turn * polygons.z[h] + shift
    return moved(polygons.z[h], turn, shift, polygons.curvature)


@kernel
def from_corner(h: int, offset: float, polygons: Polygons) -> State:
    """The line that starts at a vertex, at an angle from a half-edge into its triangle."""
    side = toward(polygons.z[h], polygons.z[following(h)], polygons.curvature)
    length = norm(side)
    turn = complex(side.real / length, -side.imag / length) * polar(1.0, -offset)
    return following(h), turn, -turn * polygons.z[h]


@kernel
def from_inside(f: int, start: complex, angle: float, polygons: Polygons) -> State:
    """The line that starts in a face, at an angle from the x axis of its polygon."""
    turn = polar(1.0, -angle)
    shift = -turn * start
    z = [moved(polygons.z[3 * f + c], turn, shift, polygons.curvature) for c in range(3)]
    k = -1
    for c in range(3):
        if z[c].imag < 0 <= z[(c + 1) % 3].imag:
            k = c
    if k < 0:  # along a side, and rounding puts all corners above or all below: it leaves at the corner ahead
        for c in range(3):
            if k < 0 or z[c].real * norm(z[k]) > z[k].real * norm(z[c]):
                k = c
        if max(z[0].imag, z[1].imag, z[2].imag) <= 0:
            k = (k + 2) % 3
    return 3 * f + k, turn, shift


@kernel(forceinline=True)
def crossed(state: State, polygons: Polygons) -> State:
    """The line one triangle on."""
    out, turn, shift = state
    z, g = polygons.z, polygons.twins[out]
    if polygons.fixed[out]:
        a, b, c, d = z[out], z[following(out)], z[following(g)], z[g]  # in two frames
        if polygons.curvature == 0:
            there = turn * (b - a) * (d - c).conjugate()
            shift += (turn * (a + b) - there / norm(there) * (c + d)) / 2
            turn = there / norm(there)
        else:
            upper = place(following(out), state, polygons)
            turn, shift = motion(place(out, state, polygons), upper, c, d, polygons.curvature)
    ahead = moved(z[preceding(g)], turn, shift, polygons.curvature)
    return following(g) if ahead.imag > 0 else preceding(g), turn, shift


@kernel(forceinline=True)
def reaches(state: State, length: float, polygons: Polygons) -> bool:
    """Whether the line is still in its triangle at this distance from its start."""
    lower = place(state[0], state, polygons)
    upper = place(following(state[0]), state, polygons)
    k = polygons.curvature
    if k == 0:
        return (upper.imag - lower.imag) * (lower.real - length) >= (upper.real - lower.real) * lower.imag
    # On hyperboloid or sphere the point of the axis between them is a sum of both.
    sine = lower.real * upper.imag - upper.real * lower.imag
    cosine = (1 - k / 4 * dot(lower, lower)) * upper.imag - (1 - k / 4 * dot(upper, upper)) * lower.imag
    return sine * cs(length, k) >= cosine * sn(length, k)


@kernel
def straight(state: State, length: float, polygons: Polygons) -> State:
    """Follow a line over a distance; ``out`` is -1 if that leads across absurdly many triangles."""
    for _ in range(polygons.twins.size + EXTRA_CROSSINGS):
        if reaches(state, length, polygons):
            return state
        state = crossed(state, polygons)
        if np.isnan(state[2].real):
            break
    _, turn, shift = state
    return -1, turn, shift
