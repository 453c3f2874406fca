"""Residuals of lengths to twice the digits of floats, with bounds on what is still missing.

The residuals of an answer are rounding errors themselves. So differences and products are split into their
rounded values and what rounding took from them, which are floats, too (Dekker, A floating-point technique
for extending the available precision, Numer. Math. 18, 1971).
"""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.linalg.rounding import GUARD, UNDERFLOW, U


def enclosed_residuals(
    edges: Indices, vertices: Floats, corrections: Floats, lengths: Floats
) -> tuple[Floats, Floats]:
    """``(|x_a - x_b|^2 - l_ab^2) / (2 l_ab)`` at x, the exact sums of vertices and corrections.

    Parameters
    ----------
    edges : ndarray of int, shape (E, 2)
    vertices, corrections : ndarray, shape (V, 3)
        The corrections are small.
    lengths : ndarray, shape (E,)
        Near 1.

    Returns
    -------
    values, errors : ndarray, shape (E,)
        The exact residuals are within the errors of the values.
    """
    a, b = edges.T
    d, lost = _difference(vertices[a], vertices[b])
    square, square_lost = _product(d, d)
    goal, goal_lost = _product(lengths, lengths)
    total, first = _sum(square[:, 0], square[:, 1])
    total, second = _sum(total, square[:, 2])
    total, third = _sum(total, -goal)
    small = first + second + third + (square_lost + 2 * d * lost).sum(axis=1) - goal_lost
    # Each of the dozen small terms is at most 2 U size, each sum of them is off by U; 1 for |lost|^2.
    size = square.sum(axis=1) + goal
    value = total + small
    error = 2 * U * np.abs(value) + 200 * U * U * size

    shift = corrections[a] - corrections[b]
    moved = (2 * d * shift + shift * shift).sum(axis=1)
    # 2 lost shift is left out, too.
    error += 12 * U * (2 * np.abs(d * shift) + shift * shift).sum(axis=1)
    value += moved
    error += 4 * U * np.abs(value) + UNDERFLOW
    return value / (2 * lengths), GUARD * error / (2 * lengths)


def _sum(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return x + y exactly, as a float and what its rounding lost."""
    total = x + y
    part = total - x
    return total, (x - (total - part)) + (y - part)


def _difference(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    return _sum(x, -y)


def _product(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return x y exactly, as a float and what its rounding lost (but for underflow)."""
    product = x * y
    (x0, x1), (y0, y1) = _halves(x), _halves(y)
    return product, x1 * y1 - (((product - x0 * y0) - x1 * y0) - x0 * y1)


def _halves(x: Floats) -> tuple[Floats, Floats]:
    """Return two floats of at most 26 bits each with the sum x."""
    scaled = (2.0**27 + 1) * x
    high = scaled - (scaled - x)
    return high, x - high
