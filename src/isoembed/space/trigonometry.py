"""Triangles of constant curvature from their sides, accurate for needles and caps; for kernels.

The curvature k is signed: with r = 1 / sqrt(|k|), ``sn(x) = r sin(x / r)`` on the sphere and r sinh(x / r) in
the hyperbolic plane, and ``cs`` is its derivative.  In the plane sn(x) = x and cs(x) = 1, to which all of it
tends, to rounding, as k does to zero.  The formulas of spherical trigonometry (half angles, L'Huilier's) hold
for all three if written in sn and cs.  Differences of sides are formed before they can cancel, as in Kahan's
"Miscalculating area and angles of a needle-like triangle" (2014).
"""

import math

import numpy as np

from isoembed.kernel import kernel

SERIES = 0.1  # squared radii of curvature: smaller squares of sides have their sine and cosine by series


@kernel
def sn(x: float, k: float) -> float:
    """Sine: the solution of ``f'' = -k f`` with f(0) = 0, f'(0) = 1."""
    if k == 0:
        return x
    t = k * x * x
    if abs(t) < SERIES:
        tail = 1 / 5040 - t * (1 / 362880 - t * (1 / 39916800 - t / 6227020800))
        return x - x * t * (1 / 6 - t * (1 / 120 - t * tail))
    root = np.sqrt(abs(k))
    return math.sin(root * x) / root if k > 0 else math.sinh(root * x) / root


@kernel
def cs(x: float, k: float) -> float:
    """Cosine: the derivative of `sn`, without a unit."""
    if k == 0:
        return 1.0
    t = k * x * x
    if abs(t) < SERIES:
        tail = 1 / 40320 - t * (1 / 3628800 - t * (1 / 479001600 - t / 87178291200))
        return 1 - t * (1 / 2 - t * (1 / 24 - t * (1 / 720 - t * tail)))
    x = np.sqrt(abs(k)) * x
    return math.cos(x) if k > 0 else math.cosh(x)


@kernel
def tn(x: float, k: float) -> float:
    """Tangent ``sn / cs``."""
    return sn(x, k) / np.float64(cs(x, k))


@kernel
def versine(x: float, k: float) -> float:
    """``(1 - cs(x)) / k``, without cancellation; x^2 / 2 in the plane."""
    s = sn(x / 2, k)
    return 2 * s * s


@kernel
def chord(l: float, k: float) -> float:
    """Straight distance, in the space around hyperboloid or sphere, of points at a distance l."""
    return 2 * sn(l / 2, k)


@kernel
def arc(c: float, k: float) -> float:
    """Distance of points that are a chord apart."""
    if k == 0:
        return c
    root = np.sqrt(abs(k))
    half = root * c / 2
    return 2 * (math.asin(min(half, 1.0)) if k > 0 else math.asinh(half)) / root


@kernel
def _descending(a: float, b: float, c: float) -> tuple[float, float, float]:
    if a < b:
        a, b = b, a
    if a < c:
        a, c = c, a
    if b < c:
        b, c = c, b
    return a, b, c


@kernel
def twice_area(a: float, b: float, c: float) -> float:
    """Twice the area of a triangle of the plane from its sides, by Kahan's formula; 0 if they make none."""
    a, b, c = _descending(a, b, c)
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return np.sqrt(square) / 2 if square > 0 else 0.0


@kernel
def amplitude(a: float, b: float, c: float, k: float) -> float:
    """``sn(a) sn(b) sin(C)``, C the angle across from c; twice the area in the plane; 0 for no triangle."""
    return twice_area(a, b, c) if k == 0 else _curved_amplitude(a, b, c, k)


@kernel
def _curved_amplitude(a: float, b: float, c: float, k: float) -> float:
    a, b, c = _descending(a, b, c)
    square = sn((a + (b + c)) / 2, k) * sn((c - (a - b)) / 2, k)
    square *= sn((c + (a - b)) / 2, k) * sn((a + (b - c)) / 2, k)
    return 2 * np.sqrt(square) if square > 0 else 0.0


@kernel
def triangle_area(a: float, b: float, c: float, k: float) -> float:
    """Area of a triangle, by L'Huilier's formula; 0 where the sides make none."""
    if k == 0:
        return twice_area(a, b, c) / 2
    a, b, c = _descending(a, b, c)
    square = tn((a + (b + c)) / 4, k) * tn((c - (a - b)) / 4, k)
    square *= tn((c + (a - b)) / 4, k) * tn((a + (b - c)) / 4, k)
    return 4 * math.atan(abs(k) * np.sqrt(square)) / abs(k) if square > 0 else 0.0


@kernel
def angle_between(a: float, b: float, across: float, k: float) -> float:
    """Angle between sides a and b of a triangle, by Kahan's formula or that of half angles."""
    s = across
    if a < b:
        a, b = b, a
    mu = s - (a - b) if b >= s else b - (a - s)
    if k != 0:
        return _half_angles((a - b) + s, mu, a + (b + s), (a - s) + b, k)
    return 2 * math.atan2(
        np.sqrt(max(((a - b) + s) * mu, 0.0)), np.sqrt((a + (b + s)) * max((a - s) + b, 0.0))
    )


@kernel
def _half_angles(p: float, q: float, r: float, s: float, k: float) -> float:
    sine, cosine = sn(p / 2, k) * sn(q / 2, k), sn(r / 2, k) * sn(s / 2, k)
    return 2 * math.atan2(np.sqrt(max(sine, 0.0)), np.sqrt(max(cosine, 0.0)))


@kernel(forceinline=True)
def apex(l: float, second: float, third: float, k: float) -> tuple[float, float]:
    """Third corner of a triangle whose side l runs from the origin along x; second follows l, third closes.

    Returns
    -------
    float, float
        The first two coordinates of the corner on hyperboloid or sphere, whose last is ``cs(third)``.
    """
    if k == 0:
        return (l + (third - second) * (third + second) / l) / 2, twice_area(l, second, third) / l
    return _curved_apex(l, second, third, k)


@kernel
def _curved_apex(l: float, second: float, third: float, k: float) -> tuple[float, float]:
    side = np.float64(sn(l, k))
    difference = 2 * sn((third - second) / 2, k) * sn((third + second) / 2, k)
    return (versine(l, k) * cs(third, k) + difference) / side, amplitude(l, second, third, k) / side
