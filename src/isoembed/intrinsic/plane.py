"""Orientation of three points of the plane."""

from dataclasses import dataclass

from isoembed.arrays import Floats
from isoembed.kernel import kernel
from isoembed.thresholds import compiled, threshold


@dataclass(frozen=True)
class PlaneThresholds:
    """Thresholds of points of the plane."""

    turn: float = threshold(
        2e-15, "sum of coordinates", "Twice the area of a triangle with corners in line, up to rounding."
    )


PLANE = PlaneThresholds()
_T = compiled(PLANE)


@kernel
def turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of triangle abc, positive if it turns left; 0 if that is lost in rounding.

    The coordinates are of the size of 1 at most.
    """
    x, y = b[0] - a[0], b[1] - a[1]
    u, v = c[0] - a[0], c[1] - a[1]
    area = x * v - y * u
    return area if abs(area) > _T.turn * (abs(x) + abs(y) + abs(u) + abs(v)) else 0.0
