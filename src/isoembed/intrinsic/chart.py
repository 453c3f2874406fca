"""Points of a surface of constant curvature in conformal coordinates, in which they move and are seen.

A point at distance d from the origin is the complex number of size ``2 tn(d / 2)`` in its direction: the disc
of Poincare, stereographic projection, or for curvature zero the plane itself.  Angles are true, circles are
circles, straight lines through the origin are straight; others become so when one of their points is moved
there, which is what `toward` does.  A motion is ``(turn, shift)``: it turns about the origin by the unit
number ``turn``, and then moves that to ``shift``.  All of it takes the arithmetic of the plane where the
curvature k is zero.
"""

import math

import numpy as np

from isoembed.arrays import Floats, Points
from isoembed.intrinsic.trigonometry import argument, dot, norm
from isoembed.kernel import kernel
from isoembed.space.trigonometry import tn


@kernel
def toward(a: complex, b: complex, k: float) -> complex:
    """Point b after the move, straight along the line through both, that takes a to the origin.

    It has the direction in which the straight line from a to b sets out, and the size ``2 tn(d / 2)``, d
    being their distance; in the plane it is b - a.
    """
    difference = b - a
    return difference if k == 0 else quotient(difference, 1.0 + k / 4 * (a.conjugate() * b))


@kernel
def moved(z: complex, turn: complex, shift: complex, k: float) -> complex:
    """Point after a motion."""
    return toward(-shift, turn * z, k)


@kernel
def turn_at(z: complex, turn: complex, shift: complex, k: float) -> float:
    """Angle by which a motion turns what leaves a point."""
    if k == 0:
        return argument(turn)
    return argument(turn) - 2 * argument(1.0 - k / 4 * (shift.conjugate() * turn * z))


@kernel
def motion(a: complex, b: complex, c: complex, d: complex, k: float) -> tuple[complex, complex]:
    """The motion that takes c to a, and d to where b is, or in line with that."""
    turn = toward(a, b, k) * toward(c, d, k).conjugate()
    turn /= norm(turn)
    scale = 1.0 + k / 4 * (a.conjugate() * turn * c)
    return quotient(turn + k / 4 * (a * c.conjugate()), scale), quotient(a - turn * c, scale)


@kernel
def quotient(a: complex, b: complex) -> complex:
    """Ratio of two numbers, rounded in the same way by all compilers."""
    product, size = a * b.conjugate(), np.float64(dot(b, b))
    return complex(product.real / size, product.imag / size)


@kernel
def coordinate(distance: float, k: float) -> float:
    """Of the point at this distance from the origin along the x axis."""
    return distance if k == 0 else 2 * tn(distance / 2, k)


@kernel
def distance(z: complex, k: float) -> float:
    """Of a point from the origin."""
    size = norm(z)
    if k == 0:
        return size
    root = np.sqrt(abs(k))
    half = root * size / 2
    return 2 * (math.atan(half) if k > 0 else math.atanh(min(half, 1.0 - 2.0**-53))) / root


@kernel
def distances(z: Points, k: float) -> Floats:
    """Of points (n,) from the origin."""
    result = np.empty(z.size)
    for i in range(z.size):
        result[i] = distance(z[i], k)
    return result


@kernel
def stretch(z: complex, k: float) -> float:
    """Ratio of these coordinates to the first two on hyperboloid or sphere, whose last is 2 / ratio - 1."""
    return 1.0 + k / 4 * dot(z, z)
