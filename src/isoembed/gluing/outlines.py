"""Curved outlines, and the equilateral polygons inscribed in them."""

import math
import numbers
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipeinc

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import is_number, side_lengths
from isoembed.gluing.thresholds import GLUING
from isoembed.intrinsic.trigonometry import apex


@dataclass(frozen=True)
class Ellipse:
    """An ellipse with semi-axes a and b, from the end (a, 0) of the first.

    Raises
    ------
    InvalidParameter
        A semi-axis is not positive and finite.
    """

    a: float
    b: float

    def __post_init__(self) -> None:
        _check_positive("ellipse", a=self.a, b=self.b)

    def points(self, u: Floats) -> Floats:
        """The points at these parts of the full angle."""
        return np.column_stack([self.a * np.cos(2 * np.pi * u), self.b * np.sin(2 * np.pi * u)])

    def parameter(self, part: float) -> float:
        """Invert Legendre's integral."""
        m = (1 - self.a / self.b) * (1 + self.a / self.b)
        target = part * ellipeinc(2 * np.pi, m)
        return float(brentq(lambda u: ellipeinc(2 * np.pi * u, m) - target, 0.0, 1.0, xtol=1e-15))


def circle(radius: float = 1.0) -> Ellipse:
    """The circle of this radius."""
    return Ellipse(radius, radius)


@dataclass(frozen=True)
class Stadium:
    """Two half circles joined by two straight sides, from the middle of the right half circle.

    Raises
    ------
    InvalidParameter
        The length of the sides or the radius is not positive and finite.
    """

    length: float
    radius: float

    def __post_init__(self) -> None:
        _check_positive("stadium", length=self.length, radius=self.radius)

    def points(self, u: Floats) -> Floats:
        """The points at these parts of the perimeter."""
        half, bow = self.length / 2, math.pi * self.radius / 2
        quarter = half + bow
        lap, s = np.divmod(4 * quarter * u, 2 * quarter)  # the second half is the first one turned by pi
        angle = np.minimum(s, bow) / self.radius + np.maximum(s - bow - self.length, 0.0) / self.radius
        x = half - np.clip(s - bow, 0.0, self.length) + self.radius * np.cos(angle)
        sign = np.where(lap % 2 == 0, 1.0, -1.0)
        return np.column_stack([sign * x, sign * self.radius * np.sin(angle)])

    def parameter(self, part: float) -> float:
        """The parameter is that part."""
        return part


Curve = Ellipse | Stadium
"""Smooth convex outlines, counterclockwise: ``points(u)`` once around from u = 0 to 1."""


def rectangle(width: float, height: float) -> Floats:
    """Corners of a rectangle, from (0, 0) along its width.

    Raises
    ------
    InvalidParameter
        A side is not positive and finite.
    """
    _check_positive("rectangle", width=width, height=height)
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def triangle(a: float, b: float, c: float) -> Floats:
    """Corners of the triangle with these sides, from (0, 0) along a; b follows.

    Raises
    ------
    InvalidParameter
        The sides are not those of a triangle.
    """
    _check_positive("triangle", a=a, b=b, c=c)
    if not max(a, b, c) < a + b + c - max(a, b, c):
        raise InvalidParameter(f"triangle has the sides {a!r}, {b!r} and {c!r}: one is too long")
    return np.array([(0.0, 0.0), (a, 0.0), apex(float(a), float(b), float(c))])


def regular_polygon(n: int, side: float = 1.0) -> Floats:
    """Corners of the regular n-gon with sides of this length.

    Raises
    ------
    InvalidParameter
        `n` is not a whole number from 3 on, or the side is not positive and finite.
    """
    check_count("n", n)
    _check_positive("regular polygon", side=side)
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle)]) * side / (2 * np.sin(np.pi / n))


def inscribed(curve: Curve, n: int, part: float) -> Floats:
    """Corners of the equilateral polygon inscribed in a curve.

    Parameters
    ----------
    curve : Ellipse or Stadium
    n : int
        Corners, at least 3.
    part : float
        Where corner 0 lies: this part of the perimeter from the beginning of the curve, from 0 to below 1.

    Returns
    -------
    ndarray, shape (n, 2)
        Counterclockwise.

    Raises
    ------
    InvalidParameter
        The curve is so long and thin that n equal sides do not come close to it.
    """
    u = curve.parameter(part) + np.arange(n + 1) / n
    aim = np.arange(n + 1) / n
    for _ in range(GLUING.spacings):
        points = curve.points(u[:-1])
        steps = side_lengths(points)
        if np.ptp(steps) <= GLUING.equal_sides * steps.sum():
            return points
        reached = np.concatenate([[0.0], np.cumsum(steps)])
        u = np.interp(aim, reached / reached[-1], u)
    raise InvalidParameter(f"{n} sides are too few for {curve!r}")


def check_count(name: str, value: int) -> None:
    """Raise `InvalidParameter` unless a value is a number of sides of a polygon."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 3:
        raise InvalidParameter(f"{name} is {value!r}, not a whole number of sides, at least 3")


def _check_positive(shape: str, **values: float) -> None:
    for name, value in values.items():
        if not is_number(value) or not 0 < value < math.inf:
            raise InvalidParameter(f"{shape} has {name} = {value!r}, not a positive finite number")
