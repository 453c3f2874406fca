"""Straight lines across triangles, which are unfolded one after another into the plane.

The line starts at the origin and runs along the positive x axis.  The triangle that it is in is known by the
half-edge through which it leaves, from a lower to an upper corner, and by where its three corners lie:
``(out, lower, upper, third)``, complex numbers.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, following, preceding, third_corner
from isoembed.intrinsic.trigonometry import apex, norm, polar
from isoembed.kernel import kernel
from isoembed.thresholds import compiled, threshold

State = tuple[int, complex, complex, complex]


@dataclass(frozen=True)
class TracingThresholds:
    """Thresholds of straight lines across triangles."""

    longest: int = threshold(
        10**6, "triangles", "A line may cross so many more than there are: round a needle."
    )
    astray: float = threshold(1e-6, "path lengths", "A path that misses its end by more went elsewhere.")


TRACING = TracingThresholds()
_T = compiled(TRACING)


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


@kernel
def from_corner(h: int, offset: float, lengths: Floats) -> State:
    """The line that starts at a vertex, at an angle from a half-edge into its triangle."""
    into = preceding(h)
    ahead = corner_angle(h, lengths) - offset
    return following(h), polar(lengths[h], -offset), polar(lengths[into], ahead), 0j


@kernel
def from_inside(f: int, start: complex, angle: float, lengths: Floats) -> State:
    """The line that starts in a face, at an angle from the first half-edge of the face, its x axis."""
    x, y = apex(lengths[3 * f], lengths[3 * f + 1], lengths[3 * f + 2])
    turn = polar(1.0, -angle)
    z = [(corner - start) * turn for corner in (0j, complex(lengths[3 * f], 0.0), complex(x, y))]
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
    return 3 * f + k, z[k], z[(k + 1) % 3], z[(k + 2) % 3]


@kernel
def crossed(state: State, mesh: HalfEdges) -> State:
    """The line one triangle on."""
    out, lower, upper, _ = state
    g = mesh.twins[out]
    corner = third_corner(g, upper, lower, mesh.lengths)
    if corner.imag > 0:
        return following(g), lower, corner, upper
    return preceding(g), corner, upper, lower


@kernel
def reaches(state: State, length: float) -> bool:
    """Whether the line is still in its triangle at this distance from its start."""
    _, lower, upper, _ = state
    return (upper.imag - lower.imag) * (lower.real - length) >= (upper.real - lower.real) * lower.imag


@kernel
def straight(state: State, length: float, mesh: HalfEdges) -> State:
    """Follow a line over a distance; ``out`` is -1 if that leads across absurdly many triangles."""
    for _ in range(mesh.twins.size + _T.longest):
        if reaches(state, length):
            return state
        state = crossed(state, mesh)
    _, lower, upper, third = state
    return -1, lower, upper, third
