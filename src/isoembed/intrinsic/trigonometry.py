"""Triangles from their sides, accurate for needles and caps, and products of vectors in the plane."""

import math

import numpy as np

from isoembed.kernel import kernel


@kernel
def twice_area(a: float, b: float, c: float) -> float:
    """Twice the area of a triangle from its sides, by Kahan's formula; 0 where they make none."""
    if a < b:
        a, b = b, a
    if a < c:
        a, c = c, a
    if b < c:
        b, c = c, b
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return np.sqrt(square) / 2 if square > 0 else 0.0


@kernel
def angle_between(a: float, b: float, across: float) -> float:
    """Angle between sides a and b of a triangle, by Kahan's formula."""
    s = across
    if a < b:
        a, b = b, a
    mu = s - (a - b) if b >= s else b - (a - s)
    return 2 * math.atan2(
        np.sqrt(max(((a - b) + s) * mu, 0.0)), np.sqrt((a + (b + s)) * max((a - s) + b, 0.0))
    )


@kernel
def apex(l: float, second: float, third: float) -> tuple[float, float]:
    """Third corner of a triangle whose side l runs from (0, 0) to (l, 0); second follows l, third closes."""
    return (l + (third - second) * (third + second) / l) / 2, twice_area(l, second, third) / l


@kernel
def dot(a: complex, b: complex) -> float:
    """Scalar product of two vectors of the plane."""
    return a.real * b.real + a.imag * b.imag


@kernel
def cross(a: complex, b: complex) -> float:
    """Vector product of two vectors of the plane: positive if b is to the left of a."""
    return a.real * b.imag - a.imag * b.real


@kernel
def norm(a: complex) -> float:
    """Length of a vector of the plane; `abs` takes the root of squares, which is not as exact."""
    return np.hypot(a.real, a.imag)


@kernel
def argument(a: complex) -> float:
    """Angle from the x axis to a vector of the plane."""
    return math.atan2(a.imag, a.real)


@kernel
def from_frame(origin: complex, axis: complex, x: float, y: float) -> complex:
    """Point with coordinates along an axis, and to the left of it, in its length."""
    return complex(origin.real + x * axis.real - y * axis.imag, origin.imag + x * axis.imag + y * axis.real)


@kernel
def polar(r: float, angle: float) -> complex:
    """Vector of the plane of this length and direction."""
    return complex(r * math.cos(angle), r * math.sin(angle))
