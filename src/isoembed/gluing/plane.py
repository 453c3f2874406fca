"""On which side of a line a point of the plane lies."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ROUNDING = 2e-15  # of a coordinate, in the unit of the largest: what points put on a line may miss it by


@njit(cache=True)
def turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of triangle abc, positive if it turns left; 0 if that is lost in rounding.

    The coordinates are of the size of 1 at most.
    """
    x, y = b[0] - a[0], b[1] - a[1]
    u, v = c[0] - a[0], c[1] - a[1]
    area = x * v - y * u
    return area if abs(area) > ROUNDING * (abs(x) + abs(y) + abs(u) + abs(v)) else 0.0
