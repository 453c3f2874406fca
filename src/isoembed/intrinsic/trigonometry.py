"""Areas, angles and corners of triangles from their sides, accurate for needles and caps."""

from __future__ import annotations

import numpy as np

from isoembed.intrinsic.kernel import kernel


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
    return 2 * np.arctan2(
        np.sqrt(max(((a - b) + s) * mu, 0.0)), np.sqrt((a + (b + s)) * max((a - s) + b, 0.0))
    )


@kernel
def apex(l: float, second: float, third: float) -> tuple[float, float]:
    """Third corner of a triangle whose side l runs from (0, 0) to (l, 0); second follows l, third closes."""
    return (l + (third - second) * (third + second) / l) / 2, twice_area(l, second, third) / l
