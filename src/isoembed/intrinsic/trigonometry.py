"""Products, lengths and directions of vectors of the plane, which are complex numbers."""

import math

import numpy as np

from isoembed.kernel import kernel


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
