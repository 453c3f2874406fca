"""Points of the plane: on which side one lies, and whether segments meet."""

from typing import cast

import numpy as np

from isoembed.arrays import Floats
from isoembed.kernel import kernel


@kernel
def turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of triangle abc, positive if it turns left; 0 if that is lost in rounding.

    The coordinates are of the size of 1 at most.
    """
    x, y = b[0] - a[0], b[1] - a[1]
    u, v = c[0] - a[0], c[1] - a[1]
    area = x * v - y * u
    # up to rounding, the corners are in line
    return area if abs(area) > 2e-15 * (abs(x) + abs(y) + abs(u) + abs(v)) else 0.0


@kernel
def meet(a: Floats, b: Floats, c: Floats, d: Floats) -> bool:
    """Whether the segments from a to b and from c to d touch or cross, up to rounding."""
    if max(a[0], b[0]) < min(c[0], d[0]) or max(c[0], d[0]) < min(a[0], b[0]):
        return False
    if max(a[1], b[1]) < min(c[1], d[1]) or max(c[1], d[1]) < min(a[1], b[1]):
        return False
    return turn(a, b, c) * turn(a, b, d) <= 0 and turn(c, d, a) * turn(c, d, b) <= 0


@kernel
def folds(a: Floats, b: Floats, c: Floats) -> bool:
    """Whether the way from a to b is gone back to c."""
    back = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0
    return back and turn(a, b, c) == 0


def flattened(arms: Floats, normal: Floats) -> Floats:
    """Coordinates in a plane in space, seen from where its normal points, shape (n, 2).

    Parameters
    ----------
    arms : ndarray, shape (n, 3)
        From one point of the plane to others.
    normal : ndarray, shape (3,)
        Of any length.
    """
    normal = normal / np.linalg.norm(normal)
    along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    along /= np.linalg.norm(along)
    return cast(Floats, arms @ np.column_stack([along, np.cross(normal, along)]))
