# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Trigonometry of constant curvature, accurate for needles and caps.

The curvature k is signed: with r = 1 / sqrt(|k|), ``sn(x) = r sin(x / r)`` on the sphere and r sinh(x / r) in
the hyperbolic plane, and ``cs`` is its derivative.  In the plane sn(x) = x and cs(x) = 1, and all formulas
tend to this case, to rounding, as k tends to zero.  The formulas of spherical trigonometry (half angles,
L'Huilier's) hold for all three if written in sn and cs.  Differences of sides are computed without
cancellation, as in Kahan's "Miscalculating area and angles of a needle-like triangle" (2014).
"""

from __future__ import annotations

import cython
from cython.cimports.libc.math import asin, asinh, atan, atan2, cos, cosh, sin, sinh, sqrt

# in squared radii of curvature: for smaller squared sides, sine and cosine are computed by series
SERIES = cython.declare(cython.double, 0.1)


@cython.ccall
@cython.exceptval(check=False)
def sn(x: cython.double, k: cython.double) -> cython.double:
    """Sine: solution of ``f'' = -k f`` with f(0) = 0, f'(0) = 1."""
    if k == 0:
        return x
    t = k * x * x
    if abs(t) < SERIES:
        tail = 1.0 / 5040 - t * (1.0 / 362880 - t * (1.0 / 39916800 - t / 6227020800))
        return x - x * t * (1.0 / 6 - t * (1.0 / 120 - t * tail))
    root = sqrt(abs(k))
    return sin(root * x) / root if k > 0 else sinh(root * x) / root


@cython.ccall
@cython.exceptval(check=False)
def cs(x: cython.double, k: cython.double) -> cython.double:
    """Cosine: derivative of `sn`, dimensionless."""
    if k == 0:
        return 1.0
    t = k * x * x
    if abs(t) < SERIES:
        tail = 1.0 / 40320 - t * (1.0 / 3628800 - t * (1.0 / 479001600 - t / 87178291200))
        return 1 - t * (1.0 / 2 - t * (1.0 / 24 - t * (1.0 / 720 - t * tail)))
    x = sqrt(abs(k)) * x
    return cos(x) if k > 0 else cosh(x)


@cython.ccall
@cython.exceptval(check=False)
def tn(x: cython.double, k: cython.double) -> cython.double:
    """Tangent ``sn / cs``."""
    return sn(x, k) / cs(x, k)


@cython.ccall
@cython.exceptval(check=False)
def versine(x: cython.double, k: cython.double) -> cython.double:
    """``(1 - cs(x)) / k``, without cancellation; x^2 / 2 in the plane."""
    s = sn(x / 2, k)
    return 2 * s * s


@cython.ccall
@cython.exceptval(check=False)
def chord(l: cython.double, k: cython.double) -> cython.double:
    """Chord, in the space around hyperboloid or sphere, of points at a distance l."""
    return 2 * sn(l / 2, k)


@cython.ccall
@cython.exceptval(check=False)
def arc(c: cython.double, k: cython.double) -> cython.double:
    """Distance of points with this chord."""
    if k == 0:
        return c
    root = sqrt(abs(k))
    half = root * c / 2
    return 2 * (asin(min(half, 1.0)) if k > 0 else asinh(half)) / root


@cython.cfunc
@cython.exceptval(check=False)
def _descending(
    a: cython.double, b: cython.double, c: cython.double
) -> tuple[cython.double, cython.double, cython.double]:
    if a < b:
        a, b = b, a
    if a < c:
        a, c = c, a
    if b < c:
        b, c = c, b
    return a, b, c


@cython.ccall
@cython.exceptval(check=False)
def twice_area(a: cython.double, b: cython.double, c: cython.double) -> cython.double:
    """Twice the area of a plane triangle from its sides, by Kahan's formula; 0 if there is no triangle."""
    a, b, c = _descending(a, b, c)
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return sqrt(square) / 2 if square > 0 else 0.0


@cython.ccall
@cython.exceptval(check=False)
def amplitude(a: cython.double, b: cython.double, c: cython.double, k: cython.double) -> cython.double:
    """``sn(a) sn(b) sin(C)``, C the angle opposite to c; in the plane twice the area; 0 if no triangle."""
    return twice_area(a, b, c) if k == 0 else _curved_amplitude(a, b, c, k)


@cython.cfunc
@cython.exceptval(check=False)
def _curved_amplitude(
    a: cython.double, b: cython.double, c: cython.double, k: cython.double
) -> cython.double:
    a, b, c = _descending(a, b, c)
    square = sn((a + (b + c)) / 2, k) * sn((c - (a - b)) / 2, k)
    square *= sn((c + (a - b)) / 2, k) * sn((a + (b - c)) / 2, k)
    return 2 * sqrt(square) if square > 0 else 0.0


@cython.ccall
@cython.exceptval(check=False)
def triangle_area(a: cython.double, b: cython.double, c: cython.double, k: cython.double) -> cython.double:
    """Area of a triangle, by L'Huilier's formula; 0 if there is no triangle."""
    if k == 0:
        return twice_area(a, b, c) / 2
    a, b, c = _descending(a, b, c)
    square = tn((a + (b + c)) / 4, k) * tn((c - (a - b)) / 4, k)
    square *= tn((c + (a - b)) / 4, k) * tn((a + (b - c)) / 4, k)
    return 4 * atan(abs(k) * sqrt(square)) / abs(k) if square > 0 else 0.0


@cython.ccall
@cython.exceptval(check=False)
def angle_between(
    a: cython.double, b: cython.double, across: cython.double, k: cython.double
) -> cython.double:
    """Angle between sides a and b of a triangle, by Kahan's formula or the half-angle formula."""
    s = across
    if a < b:
        a, b = b, a
    mu = s - (a - b) if b >= s else b - (a - s)
    if k != 0:
        return _half_angles((a - b) + s, mu, a + (b + s), (a - s) + b, k)
    return 2 * atan2(sqrt(max(((a - b) + s) * mu, 0.0)), sqrt((a + (b + s)) * max((a - s) + b, 0.0)))


@cython.cfunc
@cython.exceptval(check=False)
def _half_angles(
    p: cython.double, q: cython.double, r: cython.double, s: cython.double, k: cython.double
) -> cython.double:
    sine, cosine = sn(p / 2, k) * sn(q / 2, k), sn(r / 2, k) * sn(s / 2, k)
    return 2 * atan2(sqrt(max(sine, 0.0)), sqrt(max(cosine, 0.0)))


@cython.ccall
@cython.exceptval(check=False)
def apex(
    l: cython.double, second: cython.double, third: cython.double, k: cython.double
) -> tuple[cython.double, cython.double]:
    """Third corner of a triangle with side l from the origin along x, followed by sides second and third.

    Returns
    -------
    float, float
        First two coordinates of the corner on hyperboloid or sphere; the last one is ``cs(third)``.
    """
    if k == 0:
        return (l + (third - second) * (third + second) / l) / 2, twice_area(l, second, third) / l
    return _curved_apex(l, second, third, k)


@cython.cfunc
@cython.exceptval(check=False)
def _curved_apex(
    l: cython.double, second: cython.double, third: cython.double, k: cython.double
) -> tuple[cython.double, cython.double]:
    side = sn(l, k)
    difference = 2 * sn((third - second) / 2, k) * sn((third + second) / 2, k)
    return (versine(l, k) * cs(third, k) + difference) / side, amplitude(l, second, third, k) / side
