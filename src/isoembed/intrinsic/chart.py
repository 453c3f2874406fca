# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Conformal (stereographic) charts of surfaces of constant curvature: points, motions, distances.

A point at distance d from the origin is the complex number of modulus ``2 tn(d / 2)`` in its direction: the
Poincare disc, the stereographic projection or, for zero curvature, the plane itself.  Angles and circles are
preserved, geodesics through the origin are straight lines; others become straight when one of their points is
moved to the origin, as by `toward`.  A motion is ``(turn, shift)``: a rotation about the origin by the unit
number ``turn``, followed by the translation of the origin to ``shift``.  For zero curvature k, all operations
reduce to those of the plane.
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
    """Plane vector with these coordinates."""
    if cython.compiled:
        z: Complex = x
        z.imag = y
        return z
    return complex(x, y)


@cython.cfunc
@cython.exceptval(check=False)
def dot(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.double:
    """Scalar product of two plane vectors."""
    return a.real * b.real + a.imag * b.imag


@cython.cfunc
@cython.exceptval(check=False)
def cross(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.double:
    """Cross product of two plane vectors: positive if b is to the left of a."""
    return a.real * b.imag - a.imag * b.real


@cython.cfunc
@cython.exceptval(check=False)
def norm(a: cython.doublecomplex) -> cython.double:
    """Length of a plane vector, more accurate than `abs`, the root of the sum of squares."""
    return hypot(a.real, a.imag)


@cython.cfunc
@cython.exceptval(check=False)
def argument(a: cython.doublecomplex) -> cython.double:
    """Angle from the x axis to a plane vector."""
    return atan2(a.imag, a.real)


@cython.cfunc
@cython.exceptval(check=False)
def from_frame(
    origin: cython.doublecomplex, axis: cython.doublecomplex, x: cython.double, y: cython.double
) -> cython.doublecomplex:
    """Point with coordinates along an axis and to the left of it, in units of the axis."""
    return point(origin.real + x * axis.real - y * axis.imag, origin.imag + x * axis.imag + y * axis.real)


@cython.cfunc
@cython.exceptval(check=False)
def polar(r: cython.double, angle: cython.double) -> cython.doublecomplex:
    """Plane vector with this length and direction."""
    return point(r * cos(angle), r * sin(angle))


@cython.ccall
@cython.exceptval(check=False)
def toward(a: cython.doublecomplex, b: cython.doublecomplex, k: cython.double) -> cython.doublecomplex:
    """Image of point b under the translation along the line through both that moves a to the origin.

    It has the initial direction of the geodesic from a to b, and modulus ``2 tn(d / 2)`` for the distance d
    of the points; in the plane it is b - a.
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
    """Angle by which a motion rotates directions at a point."""
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
    """Motion from c to a, and from d to b or to a point on the line from a to b."""
    turn = toward(a, b, k) * toward(c, d, k).conjugate()
    turn /= norm(turn)
    scale = 1.0 + k / 4 * (a.conjugate() * turn * c)
    return quotient(turn + k / 4 * (a * c.conjugate()), scale), quotient(a - turn * c, scale)


@cython.cfunc
@cython.exceptval(check=False)
def quotient(a: cython.doublecomplex, b: cython.doublecomplex) -> cython.doublecomplex:
    """Quotient of two numbers, rounded in the same way by all compilers."""
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
    """Ratio of these coordinates to the first two on hyperboloid or sphere; the last one is 2 / ratio - 1."""
    return 1.0 + k / 4 * dot(z, z)
