# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Conformal (stereographic) charts of surfaces of constant curvature: points, motions, distances.

A point at distance d from the origin is the complex number of size ``2 tn(d / 2)`` in its direction: the disc
of Poincare, stereographic projection, or for curvature zero the plane itself.  Angles are true, circles are
circles, straight lines through the origin are straight; others become so when one of their points is moved
there, which is what `toward` does.  A motion is ``(turn, shift)``: it turns about the origin by the unit
number ``turn``, and then moves that to ``shift``.  All of it takes the arithmetic of the plane where the
curvature k is zero.
"""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstComplex, Real
from cython.cimports.isoembed.space.trigonometry import tn
from cython.cimports.libc.math import atan, atan2, atanh, cos, hypot, sin, sqrt


@cython.cfunc
@cython.exceptval(check=False)
def point(x: cython.double, y: cython.double) -> cython.doublecomplex:
    """Vector of the plane with these coordinates."""
    if cython.compiled:
        z: Complex = x
        z.imag = y
        return z
    return complex(x, y)


@cython.cfunc
@cython.exceptval(check=False)
def dot(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.double:
    """Scalar product of two vectors of the plane."""
    return a.real * b.real + a.imag * b.imag


@cython.cfunc
@cython.exceptval(check=False)
def cross(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.double:
    """Vector product of two vectors of the plane: positive if b is to the left of a."""
    return a.real * b.imag - a.imag * b.real


@cython.cfunc
@cython.exceptval(check=False)
def norm(a: cython.doublecomplex) -> cython.double:
    """Length of a vector of the plane; `abs` takes the root of squares, which is not as exact."""
    return hypot(a.real, a.imag)


@cython.cfunc
@cython.exceptval(check=False)
def argument(a: cython.doublecomplex) -> cython.double:
    """Angle from the x axis to a vector of the plane."""
    return atan2(a.imag, a.real)


@cython.cfunc
@cython.exceptval(check=False)
def from_frame(
    origin: cython.doublecomplex, axis: cython.doublecomplex, x: cython.double, y: cython.double
) -> cython.doublecomplex:
    """Point with coordinates along an axis, and to the left of it, in its length."""
    return point(origin.real + x * axis.real - y * axis.imag, origin.imag + x * axis.imag + y * axis.real)


@cython.cfunc
@cython.exceptval(check=False)
def polar(r: cython.double, angle: cython.double) -> cython.doublecomplex:
    """Vector of the plane of this length and direction."""
    return point(r * cos(angle), r * sin(angle))


@cython.ccall
@cython.exceptval(check=False)
def toward(a: cython.doublecomplex, b: cython.doublecomplex, k: cython.double) -> cython.doublecomplex:
    """Point b after the move, straight along the line through both, that takes a to the origin.

    It has the direction in which the straight line from a to b sets out, and the size ``2 tn(d / 2)``, d
    being their distance; in the plane it is b - a.
    """
    difference = b - a
    return difference if k == 0 else quotient(difference, 1.0 + k / 4 * (a.conjugate() * b))


@cython.ccall
@cython.exceptval(check=False)
def moved(
    z: cython.doublecomplex, turn: cython.doublecomplex, shift: cython.doublecomplex, k: cython.double
) -> cython.doublecomplex:
    """Point after a motion."""
    return toward(-shift, turn * z, k)


@cython.ccall
@cython.exceptval(check=False)
def turn_at(
    z: cython.doublecomplex, turn: cython.doublecomplex, shift: cython.doublecomplex, k: cython.double
) -> cython.double:
    """Angle by which a motion turns what leaves a point."""
    if k == 0:
        return argument(turn)
    return argument(turn) - 2 * argument(1.0 - k / 4 * (shift.conjugate() * turn * z))


@cython.ccall
@cython.exceptval(check=False)
def motion(
    a: cython.doublecomplex,
    b: cython.doublecomplex,
    c: cython.doublecomplex,
    d: cython.doublecomplex,
    k: cython.double,
) -> tuple[cython.doublecomplex, cython.doublecomplex]:
    """The motion that takes c to a, and d to where b is, or in line with that."""
    turn = toward(a, b, k) * toward(c, d, k).conjugate()
    turn /= norm(turn)
    scale = 1.0 + k / 4 * (a.conjugate() * turn * c)
    return quotient(turn + k / 4 * (a * c.conjugate()), scale), quotient(a - turn * c, scale)


@cython.cfunc
@cython.exceptval(check=False)
def quotient(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.doublecomplex:
    """Ratio of two numbers, rounded in the same way by all compilers."""
    product, size = a * b.conjugate(), dot(b, b)
    return point(product.real / size, product.imag / size)


@cython.ccall
@cython.exceptval(check=False)
def coordinate(distance: cython.double, k: cython.double) -> cython.double:
    """Coordinate of the point at this distance from the origin along the x axis."""
    return distance if k == 0 else 2 * tn(distance / 2, k)


@cython.ccall
@cython.exceptval(check=False)
def distance(z: cython.doublecomplex, k: cython.double) -> cython.double:
    """Distance of a point from the origin."""
    size = norm(z)
    if k == 0:
        return size
    root = sqrt(abs(k))
    half = root * size / 2
    return 2 * (atan(half) if k > 0 else atanh(min(half, 1.0 - 2.0**-53))) / root


def distances(z: ConstComplex[::1], k: Real):
    """Distances of points (n,) from the origin."""
    result: Real[::1] = np.empty(z.shape[0])
    for i in range(z.shape[0]):
        result[i] = distance(z[i], k)
    return np.asarray(result)


@cython.ccall
@cython.exceptval(check=False)
def stretch(z: cython.doublecomplex, k: cython.double) -> cython.double:
    """Ratio of these coordinates to the first two on hyperboloid or sphere, whose last is 2 / ratio - 1."""
    return 1.0 + k / 4 * dot(z, z)
