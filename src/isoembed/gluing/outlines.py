"""Outlines of sheets: polygons by sides and angles, ellipses, stadiums, and equilateral polygons in them."""

import math
import numbers
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ellipeinc

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import is_number, side_lengths
from isoembed.space import Space
from isoembed.space.trigonometry import angle_between, apex


@dataclass(frozen=True)
class Ellipse:
    """An ellipse with semi-axes a and b, starting at (a, 0).

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
        """Points at given fractions of the full eccentric angle."""
        return np.column_stack([self.a * np.cos(2 * np.pi * u), self.b * np.sin(2 * np.pi * u)])

    def parameter(self, part: float) -> float:
        """Parameter at a fraction of the perimeter, by inversion of the elliptic integral."""
        m = (1 - self.a / self.b) * (1 + self.a / self.b)
        target = part * ellipeinc(2 * np.pi, m)
        return float(brentq(lambda u: ellipeinc(2 * np.pi * u, m) - target, 0.0, 1.0, xtol=1e-15))


def circle(radius: float = 1.0) -> Ellipse:
    """Circle of the given radius."""
    return Ellipse(radius, radius)


@dataclass(frozen=True)
class Stadium:
    """Two half circles joined by two straight sides, starting at the middle of the right half circle.

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
        """Points at given fractions of the perimeter."""
        half, bow = self.length / 2, math.pi * self.radius / 2
        quarter = half + bow
        lap, s = np.divmod(4 * quarter * u, 2 * quarter)  # the second half is the first one rotated by pi
        angle = np.minimum(s, bow) / self.radius + np.maximum(s - bow - self.length, 0.0) / self.radius
        x = half - np.clip(s - bow, 0.0, self.length) + self.radius * np.cos(angle)
        sign = np.where(lap % 2 == 0, 1.0, -1.0)
        return np.column_stack([sign * x, sign * self.radius * np.sin(angle)])

    def parameter(self, part: float) -> float:
        """Parameter at a fraction of the perimeter, which is the fraction itself."""
        return part


Curve = Ellipse | Stadium
"""Smooth convex outlines, counterclockwise: ``points(u)`` goes around once for u from 0 to 1."""


def rectangle(width: float, height: float) -> Floats:
    """Corners of a rectangle, from (0, 0) along its width.

    Raises
    ------
    InvalidParameter
        A side is not positive and finite.
    """
    _check_positive("rectangle", width=width, height=height)
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def triangle(a: float, b: float, c: float, *, curvature: float = 0.0) -> Floats:
    """Corners of a triangle with given sides, starting at (0, 0) along a, followed by b.

    With a curvature, the triangle lies in the hyperbolic plane or on the sphere, about the origin, in ambient
    coordinates.

    Raises
    ------
    InvalidParameter
        The sides violate the triangle inequality.
    """
    _check_positive("triangle", a=a, b=b, c=c)
    if not max(a, b, c) < a + b + c - max(a, b, c):
        raise InvalidParameter(f"triangle has the sides {a!r}, {b!r} and {c!r}: one is too long")
    space = Space(curvature)
    if space.curvature > 0 and not a + b + c < 2 * math.pi * space.radius:
        raise InvalidParameter(f"triangle has the sides {a!r}, {b!r} and {c!r}: at least a great circle")
    if not space.is_euclidean:
        between = angle_between(float(a), float(b), float(c), space.curvature)
        return from_sides([a, b], [between], curvature=space.curvature)
    return np.array([(0.0, 0.0), (a, 0.0), apex(float(a), float(b), float(c), 0.0)])


def regular_polygon(n: int, side: float = 1.0, *, curvature: float = 0.0) -> Floats:
    """Corners of a regular n-gon with sides of the given length.

    With a curvature, it lies in the hyperbolic plane or on the sphere, in ambient coordinates.

    Raises
    ------
    InvalidParameter
        `n` is not an integer of at least 3, or the side is not positive and finite, or too long for the
        sphere.
    """
    check_count(n)
    _check_positive("regular polygon", side=side)
    space = Space(curvature)
    if space.curvature > 0 and not n * side < 2 * math.pi * space.radius:
        raise InvalidParameter(f"regular polygon has {n} sides of {side!r}, at least a great circle")
    angle = 2 * np.pi * np.arange(n) / n
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return circle * float(space.chord(np.float64(side))) / (2 * np.sin(np.pi / n))


def from_sides(sides: ArrayLike, angles: ArrayLike, *, curvature: float = 0.0) -> Floats:
    """Corners of a polygon from its sides and the angles between them; the last side closes it.

    Parameters
    ----------
    sides : array_like, shape (n - 1,)
        Lengths of all sides but the last, counterclockwise.
    angles : array_like, shape (n - 2,)
        Interior angles between them, radians.
    curvature : float, optional
        Curvature of the hyperbolic plane (negative) or sphere (positive) that contains the polygon.

    Returns
    -------
    ndarray, shape (n, 2)
        Corners, from (0, 0) along the first side; with a curvature about the origin, in ambient coordinates.

    Raises
    ------
    InvalidParameter
        The sides or angles are invalid, or the polygon does not fit into a hemisphere.

    Examples
    --------
    A pentagon in the hyperbolic plane with five right angles, three of which are given:

    >>> side = 2 * np.arccosh(np.cos(np.pi / 5) / np.sin(np.pi / 4))
    >>> pentagon = from_sides([side] * 4, [np.pi / 2] * 3, curvature=-1.0)
    >>> bool(np.allclose(np.linalg.norm(pentagon, axis=1), np.linalg.norm(pentagon[0])))
    True
    """
    try:
        steps, turns = (np.asarray(given, dtype=np.float64) for given in (sides, angles))
    except (TypeError, ValueError):  # strings, or rows of different sizes
        raise InvalidParameter("the sides and the angles are not lists of numbers") from None
    if steps.ndim != 1 or steps.size < 2 or turns.shape != (steps.size - 1,):
        raise InvalidParameter(
            f"there are sides of shape {steps.shape} and angles of shape {turns.shape}: a polygon with "
            "n sides takes n - 1 sides and the n - 2 angles between them"
        )
    space = Space(curvature)
    for k, side in enumerate(steps.tolist()):
        _check_positive(f"side {k} of the polygon", length=side)
    inside = (turns > 0) & (turns < 2 * np.pi)
    if not inside.all():
        k = int(np.argmin(inside))
        raise InvalidParameter(f"angle {k} of the polygon is {float(turns[k])!r}, not between 0 and 2 pi")
    half = math.pi * space.radius
    if space.curvature > 0 and not (steps < half).all():
        k = int(np.argmin(steps < half))
        raise InvalidParameter(f"side {k} of the polygon is {steps[k]:.9g}, at least half a great circle")
    frame, points = np.eye(3), [np.array([0.0, 0.0, 1.0])]
    for step, turn in zip(steps, np.pi - np.append(turns, np.pi), strict=True):
        s, c = space.sn(step), space.cs(step)
        frame = frame @ [[c, 0, s], [0, 1, 0], [-space.curvature * s, 0, c]]
        points.append(frame[:, 2])
        frame = frame @ [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    corners = np.array(points)
    return corners[:, :2] if space.is_euclidean else _about_the_origin(corners, space)


def _about_the_origin(points: Floats, space: Space) -> Floats:
    """Ambient coordinates (n, 2) of points (n, 3) of sphere or hyperboloid, with their sum moved to the axis.

    Raises
    ------
    InvalidParameter
        The points on the sphere do not lie in the hemisphere about their sum.
    """
    k = space.curvature
    total = points.sum(axis=0)
    x, y, w = total / np.sqrt(k * (total[0] ** 2 + total[1] ** 2) + total[2] ** 2)
    heights = points[:, 2] * w + k * (points[:, 0] * x + points[:, 1] * y)
    if not (heights > 0).all():
        k = int(np.argmin(heights > 0))
        raise InvalidParameter(
            f"corner {k} of the polygon does not lie in a common hemisphere with the others"
        )
    # Translation along the geodesic through both.
    share = (points[:, 2] + heights) / (1 + w)
    return np.asarray(points[:, :2] - share[:, None] * [x, y])


def inscribed(curve: Curve, n: int, part: float) -> Floats:
    """Corners of the equilateral polygon inscribed in a curve.

    Parameters
    ----------
    curve : Ellipse or Stadium
    n : int
        Number of corners, at least 3.
    part : float
        Position of corner 0 as a fraction of the perimeter from the start of the curve, in [0, 1).

    Returns
    -------
    ndarray, shape (n, 2)
        Corners, counterclockwise.

    Raises
    ------
    InvalidParameter
        The curve is too elongated for an approximation by n equal sides.
    """
    u = curve.parameter(part) + np.arange(n + 1) / n
    aim = np.arange(n + 1) / n
    for _ in range(1000):  # each gains a digit or more
        points = curve.points(u[:-1])
        steps = side_lengths(points)
        if np.ptp(steps) <= 1e-14 * steps.sum():  # up to rounding
            return points
        reached = np.concatenate([[0.0], np.cumsum(steps)])
        u = np.interp(aim, reached / reached[-1], u)
    raise InvalidParameter(f"{n} sides are too few for {curve!r}")


def check_count(n: int) -> None:
    """Raise `InvalidParameter` unless n is a valid number of sides of a polygon."""
    if isinstance(n, bool) or not isinstance(n, numbers.Integral) or n < 3:
        raise InvalidParameter(f"n is {n!r}, not a whole number of sides, at least 3")


def check_fraction(name: str, value: float) -> None:
    """Raise `InvalidParameter` unless a value is a fraction of the perimeter."""
    if not is_number(value) or not 0 <= value < 1:
        raise InvalidParameter(f"{name} is {value!r}, not a fraction of the perimeter in [0, 1)")


def _check_positive(shape: str, **values: float) -> None:
    for name, value in values.items():
        if not is_number(value) or not 0 < value < math.inf:
            raise InvalidParameter(f"{shape} has {name} = {value!r}, not a positive finite number")
