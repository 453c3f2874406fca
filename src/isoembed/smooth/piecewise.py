"""Piecewise Chebyshev series with adaptive bisection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric

PIECE_DEGREE = 32  # higher degrees lose digits in differentiation


@dataclass(frozen=True, eq=False)
class Piecewise:
    """Piecewise Chebyshev series on an interval.

    Attributes
    ----------
    breaks : ndarray, shape (k + 1,)
        Break points in increasing order.
    coefficients : ndarray, shape (degree + 1, k)
    """

    breaks: Floats
    coefficients: Floats

    def local(self, x: Floats) -> tuple[Indices, Floats]:
        """Index of the piece of each x, and its local coordinate between -1 and 1."""
        i = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, len(self.breaks) - 2)
        a, b = self.breaks[i], self.breaks[i + 1]
        return i, ((x - a) - (b - x)) / (b - a)

    def __call__(self, x: Floats) -> Floats:
        """Values at x (n,)."""
        i, t = self.local(x)
        return np.asarray(chebyshev.chebval(t, self.coefficients[:, i], tensor=False))

    def derivative(self) -> Piecewise:
        """Derivative, on the same pieces."""
        return Piecewise(
            self.breaks, chebyshev.chebder(self.coefficients, axis=0) * (2.0 / np.diff(self.breaks))
        )

    def primitive(self) -> Piecewise:
        """Integral from the first break point."""
        series = chebyshev.chebint(self.coefficients, lbnd=-1.0, axis=0) * (0.5 * np.diff(self.breaks))
        series[0, 1:] += np.cumsum(series.sum(axis=0))[:-1]
        return Piecewise(self.breaks, series)


def value_at(f: Callable[[Floats], Floats], x: float) -> float:
    """Value of a function of arrays at one point."""
    return float(f(np.array([x]))[0])


@dataclass(frozen=True, eq=False)
class Samples:
    """Values (m, n) of m functions at x (n,), and their rounding errors (n,), relative to the largest."""

    x: Floats
    values: Floats
    rounding: Floats


def fitted(
    f: Callable[[Floats], Floats], breaks: Floats, weighted: bool, samples: Samples | None = None
) -> tuple[tuple[Piecewise, ...], float]:
    """Series for m functions f: (n,) -> (m, n) on common pieces, and the relative accuracy reached.

    Pieces are bisected until their series converge, and agree with the `samples`: features narrower than the
    distance of the nodes leave no trace in the series.  `weighted` weights errors by the widths of the
    pieces, which suffices for integrals.  The tolerance is relaxed if noise leads to too many pieces.
    """
    for tolerance in (2e-15, 2e-14, 2e-13, 2e-12, 2e-11, 2e-10, 2e-9, 2e-8, 2e-7, 2e-6, 2e-5):
        result = _bisected(f, breaks, weighted, tolerance, samples)
        if result is not None:
            return result, tolerance
    raise InvalidMetric(
        "the metric is not a smooth function of theta: polynomials do not approximate it to 2e-5"
    )


def _bisected(
    f: Callable[[Floats], Floats],
    breaks: Floats,
    weighted: bool,
    tolerance: float,
    samples: Samples | None,
) -> tuple[Piecewise, ...] | None:
    n = PIECE_DEGREE + 1
    # Integer multiples of one angle, reduced: a recurrence would leave noise in the high coefficients.
    table = np.cos(np.pi / (2 * n) * (np.outer(np.arange(n), 2 * np.arange(n) + 1) % (4 * n)))
    nodes = table[1]
    to_series = table * np.append(1.0, np.full(PIECE_DEGREE, 2.0))[:, None] / n
    left, right = breaks[:-1], breaks[1:]
    total = breaks[-1] - breaks[0]
    starts: list[Floats] = []
    intervals: list[Floats] = []
    scale = np.zeros(1)
    count = 0
    while left.size:
        count += left.size
        if count > 256:  # bisected ones included
            return None
        x = left[:, None] + (right - left)[:, None] * (0.5 + 0.5 * nodes)
        values = f(x.ravel()).reshape(-1, *x.shape)
        series = np.einsum("dn,mkn->dmk", to_series, values)
        scale = np.maximum(scale, np.abs(values).max(axis=(1, 2)))
        tail = np.abs(series[-4:]).max(axis=0) / scale[:, None]
        if weighted:
            tail = tail * (right - left) / total
        good = (tail <= tolerance).all(axis=0)
        if samples is not None and good.any():
            # A larger error between nodes is not that of the tail of a series.
            good[good] = _agrees(series[:, :, good], left[good], right[good], samples, 100.0 * tolerance)
        good |= right - left <= 1e-13 * total
        # Drop coefficients at rounding level, which differentiation would amplify.
        end = np.abs(series[::-1]).cumsum(axis=0)[::-1] <= 4e-16 * scale[:, None]
        starts.append(left[good])
        intervals.append(np.where(end, 0.0, series)[:, :, good])
        middle = 0.5 * (left[~good] + right[~good])
        left, right = np.concatenate([left[~good], middle]), np.concatenate([middle, right[~good]])
    start = np.concatenate(starts)
    order = np.argsort(start)
    series = np.concatenate(intervals, axis=2)[:, :, order]
    ends = np.append(start[order], breaks[-1])
    return tuple(Piecewise(ends, series[:, m]) for m in range(series.shape[1]))


def _agrees(series: Floats, left: Floats, right: Floats, samples: Samples, tolerance: float) -> Mask:
    """Whether the series (degree + 1, m, k) of each piece (k,) agree with the samples on it."""
    order = np.argsort(left)
    piece = order[np.clip(np.searchsorted(left[order], samples.x, side="right") - 1, 0, None)]
    inside = (samples.x >= left[piece]) & (samples.x <= right[piece])
    x, piece = samples.x[inside], piece[inside]
    t = ((x - left[piece]) - (right[piece] - x)) / (right[piece] - left[piece])
    error = np.abs(chebyshev.chebval(t, series[:, :, piece], tensor=False) - samples.values[:, inside])
    scale = np.abs(samples.values).max(axis=1, keepdims=True)
    missed = (error > scale * (tolerance + samples.rounding[inside])).any(axis=0)
    return np.bincount(piece, missed, len(left)) == 0.0
