"""Enclosures of length residuals in double-double arithmetic.

The residuals of a converged solution are rounding errors themselves.  Differences and products are therefore
represented by their rounded values and rounding errors (`double_double`).
"""

from __future__ import annotations

from fractions import Fraction
from math import factorial
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.proof.double_double import (
    ADDED,
    MULTIPLIED,
    Pair,
    exact_difference,
    exact_product,
    exact_sum,
    plus,
    times,
)
from isoembed.proof.rounding import GUARD, UNDERFLOW, U


class Chords(NamedTuple):
    """Squared chords of lengths in a space of curvature k, ``2 (1 - cs(l)) / k``.

    Attributes
    ----------
    curvature : float
        k, not zero.
    squares : pair of ndarray, shape (E,)
    off : ndarray, shape (E,)
        Error bounds, in units of U^2.
    """

    curvature: float
    squares: Pair
    off: Floats


def enclosed_residuals(
    edges: Indices,
    vertices: Floats,
    corrections: Floats,
    lengths: Floats,
    chords: Chords | None = None,
    divisors: Floats | None = None,
) -> tuple[Floats, Floats]:
    """``(|x_a - x_b|^2 - c_ab^2 m_a m_b) / (2 n_ab)`` at x, the exact sums of vertices and corrections.

    In Euclidean space c = l and m = 1; otherwise c is the chord of l, and ``m = 1 + k |x|^2 / 4`` for points
    in conformal coordinates.

    Parameters
    ----------
    edges : ndarray of int, shape (E, 2)
    vertices, corrections : ndarray, shape (V, 3)
        Points and small corrections.
    lengths : ndarray, shape (E,)
        Lengths of order 1.
    chords : Chords, optional
        Chords of the lengths, in curved space.
    divisors : ndarray, shape (E,), optional
        n; by default the lengths.

    Returns
    -------
    values, errors : ndarray, shape (E,)
        The exact residuals are within the errors of the values.
    """
    a, b = edges.T
    n = lengths if divisors is None else divisors
    d, remainder = exact_difference(vertices[a], vertices[b])
    square, square_lost = exact_product(d, d)
    if chords is None:
        (goal, goal_lost), size = exact_product(lengths, lengths), np.zeros_like(lengths)
    else:
        (goal, goal_lost), size = _goals(edges, vertices, chords)
    total, first = exact_sum(square[:, 0], square[:, 1])
    total, second = exact_sum(total, square[:, 2])
    total, third = exact_sum(total, -goal)
    small = first + second + third + (square_lost + 2 * d * remainder).sum(axis=1) - goal_lost
    # Each of the dozen small terms is at most 2 U size, each sum of them has an error of U; 1 for |lost|^2.
    value = total + small
    error = 2 * U * np.abs(value) + 200 * U * U * (square.sum(axis=1) + np.abs(goal)) + U * U * size

    shift = corrections[a] - corrections[b]
    moved = (2 * d * shift + shift * shift).sum(axis=1)
    # 2 lost shift is also omitted.
    error += 12 * U * (2 * np.abs(d * shift) + shift * shift).sum(axis=1)
    value += moved
    if chords is not None:
        moved, goal_errors = _moved_goals(edges, vertices, corrections, chords)
        value -= moved
        error += goal_errors
    error += 4 * U * np.abs(value) + UNDERFLOW
    return value / (2 * n), GUARD * error / (2 * n)


def squared_chords(lengths: Floats, curvature: float) -> Chords:
    """Chords of lengths, (E,), of at most ten radii of curvature.

    Computed by the series ``l^2 sum 2 (-k l^2)^n / (2 n + 2)!`` with a remainder less than U^3.
    """
    square = exact_product(lengths, lengths)
    terms = _terms(abs(curvature) * float(square[0].max(initial=0.0)))
    t = times((np.full_like(lengths, -curvature), np.zeros_like(lengths)), square)
    total: Pair = (np.zeros_like(lengths), np.zeros_like(lengths))
    size = np.zeros_like(lengths)
    for n in range(terms, -1, -1):
        exact = Fraction(2, factorial(2 * n + 2))
        high = float(exact)
        low = float(exact - Fraction(high))
        total = plus(times(total, t), (np.full_like(lengths, high), np.full_like(lengths, low)))
        size = size * np.abs(t[0]) + high
    # Error of each step, relative to the sizes; the n-th power of t adds n times its error.
    off = (terms + 1) * (ADDED + 3 * MULTIPLIED) + MULTIPLIED
    return Chords(curvature, times(square, total), off * square[0] * size * GUARD)


def _terms(size: float) -> int:
    """Number of terms of the chord series for arguments up to this size."""
    n = 1
    while size ** (n + 1) / factorial(2 * n + 4) > U**3 / 4 or 2 * size > (2 * n + 5) * (2 * n + 6):
        n += 1
    return n


def _goals(edges: Indices, vertices: Floats, chords: Chords) -> tuple[Pair, Floats]:
    """``c^2 m_a m_b`` as pairs, and error bounds in units of U^2."""
    x, y, z = (exact_product(column, column) for column in vertices.T)
    quarter = (np.full(len(vertices), chords.curvature / 4), np.zeros(len(vertices)))
    ones = (np.ones(len(vertices)), np.zeros(len(vertices)))
    m = plus(ones, times(quarter, plus(plus(x, y), z)))
    sizes = 1 + abs(chords.curvature) / 4 * (x[0] + y[0] + z[0])
    a, b = edges.T
    goals = times(chords.squares, times((m[0][a], m[1][a]), (m[0][b], m[1][b])))
    both = sizes[a] * sizes[b]
    # errors of four sums and a product in each m; one more product for theirs and one for that with c^2
    return goals, GUARD * both * (chords.off + chords.squares[0] * (8 * ADDED + 4 * MULTIPLIED))


def _moved_goals(
    edges: Indices, vertices: Floats, corrections: Floats, chords: Chords
) -> tuple[Floats, Floats]:
    """Change of ``c^2 m_a m_b`` by the corrections, and its error."""
    quarter, squared, (a, b) = chords.curvature / 4, chords.squares[0], edges.T
    products = 2 * vertices * corrections + corrections * corrections
    change = quarter * products.sum(axis=1)
    bounds = abs(quarter) * (2 * np.abs(vertices * corrections) + corrections * corrections).sum(axis=1)
    squares = abs(quarter) * (vertices * vertices).sum(axis=1)
    m = 1 + np.copysign(squares, quarter)
    moved = squared * (m[a] * change[b] + m[b] * change[a] + change[a] * change[b])
    sizes = (1 + squares[a]) * bounds[b] + (1 + squares[b]) * bounds[a] + bounds[a] * bounds[b]
    return moved, 40 * U * squared * sizes
