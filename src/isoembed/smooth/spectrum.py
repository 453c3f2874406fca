"""Error estimates of grid functions from their Fourier coefficients.

The coefficients of a smooth function fall with their degree, those of noise do not.  What is beyond the grid
is estimated from the highest degrees that are on it.  Averages over the sphere see less of it than values at
points do: only what is aliased onto degree zero, from as far beyond the grid as the grid is high.  That
coefficients fall so far is believed only where noise is excluded: a function of degree l has no coefficients
k in theta and m in phi with k^2 + m^2 > l^2, so that in this corner of the spectrum noise is alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.smooth.double_fourier import DoubleFourier
from isoembed.smooth.resampling import Derived, truncation
from isoembed.smooth.uncertain import Uncertainty

END = 0.1  # share of the degrees that are the highest
FEWEST = 2  # highest degrees: symmetry makes some of them zero
SYMMETRIC = 1e-12  # relative dependence on phi that is zero
SCATTER = 4.0  # standard deviations, in the largest error at a point


@dataclass(frozen=True)
class Spectrum:
    """Errors of functions from their Fourier coefficients, in the unit of the functions.

    Attributes
    ----------
    largest : float
        The largest coefficient.
    tail : float
        The largest of the highest degrees, in theta or phi.  Degrees in theta that would not be resolved in
        phi count as high: what turns that fast in theta may do so in phi, unseen.
    unseen : float
        The largest of those degrees in theta alone.
    error : Uncertainty
    """

    largest: float
    tail: float
    unseen: float
    error: Uncertainty

    @classmethod
    def of(cls, functions: DoubleFourier, derived: Derived = np.asarray) -> Spectrum:
        """Spectrum of functions from their Fourier coefficients.

        Parameters
        ----------
        functions : DoubleFourier
        derived : callable
            Takes values (k, c) of the functions, over their largest coefficient, and returns functions (k, j)
            of them in the same unit, whose averages must be within the error; by default themselves.
        """
        size = np.abs(functions.coefficients)
        largest = float(size.max())
        if largest == 0.0:
            return cls(0.0, 0.0, 0.0, Uncertainty())
        size /= largest
        m = size.shape[1]
        by_degree, by_order = size.max(axis=(1, 2)), size.max(axis=(0, 2))
        ends = [(by_degree, size[0].size)] + ([(by_order, size[:, 0].size)] if m > 1 else [])
        unseen, aliased = _unseen(by_degree, by_order)
        tail = max(unseen, *(_end(values) for values, _ in ends))
        falling = max(_end(values) * _fall(values, samples) for values, samples in ends)
        noise = _noise(size)
        coarse = truncation(functions, lambda values: derived(values / largest))
        # Squares of errors do not average out.
        second = max(tail**2, 0.25 * size[:, :, 0].size * noise**2)
        mean = float(min(tail, max(falling, aliased, noise, coarse, second)))
        error = Uncertainty(
            largest * SCATTER * max(tail, _scatter(size)),
            largest * 3.0 * mean,
        )
        return cls(largest, largest * tail, largest * unseen, error)


def _share(share: float, count: int) -> int:
    return max(FEWEST, int(share * count))


def _end(values: Floats) -> float:
    """The largest of the highest degrees."""
    return float(values[-_share(END, len(values)) :].max())


def _fall(values: Floats, samples: int) -> float:
    """Sum of the coefficients beyond degree 2 n over the last of n.

    Where they fall geometrically that goes on.  Else they are taken to fall half as fast as before n; each is
    the largest of these samples, and of a narrow and a wide band the one that falls less counts.
    """
    n = len(values)
    rate = _rate(values)
    if rate > 0.0:
        return float(np.exp(-0.9 * rate * n))  # not all of the rate is trusted
    known = n >= 8  # fewer do not show how they fall
    factor = 4.0 ** (-0.5 * n)  # largest fall by one degree that is trusted
    # Where both parities are there, from one degree to the next, after what ends before the grid does.
    for last, before in zip(values[:-3:-1], values[-2:-4:-1], strict=False):
        if SYMMETRIC < last < before:
            factor = max(factor, float(last / before) ** (0.5 * n))
    for width in {FEWEST, _share(0.125, n)}:
        if n < 2 * width:
            return 1.0
        last, before = float(values[-width:].max()), float(values[-2 * width : -width].max())
        # The largest of many coefficients is left to chance.
        chance = 1.0 + 2.0 / np.sqrt(width * samples) if known else 1.0
        ratio = min(1.0, chance * last / before) if before > 0.0 else 1.0
        factor = max(factor, ratio ** (n / (2.0 * width)))
    return 3.0 * factor if known else factor  # the sum of all over the largest


def _rate(values: Floats) -> float:
    """Logarithm of the fall of coefficients (n,) by one degree, if it is geometric; 0 if not."""
    # Parity makes every other one small, or none.
    pairs = np.maximum.reduceat(values, np.arange(0, len(values), 2))
    both = min(values[::2].max(), values[1::2].max(initial=0.0)) > SYMMETRIC
    return max(0.5 * _geometric(pairs), _geometric(values) if both else 0.0)


def _geometric(values: Floats) -> float:
    """Logarithm of the fall from one of the values (n,) to the next, if it is geometric; 0 if not.

    At kinks coefficients fall like powers, slower and slower; noise ends any fall.
    """
    envelope = np.maximum.accumulate(values[::-1])[::-1]
    at = np.unique(np.linspace(len(values) // 5, len(values) - 1, 4).astype(int))
    if len(at) < 4 or envelope[-1] <= 0.0:
        return 0.0
    falls = -np.diff(np.log(envelope[at])) / np.diff(at)
    return float(falls.min()) if np.all(falls[1:] > 0.8 * falls[:-1]) else 0.0


def _unseen(by_degree: Floats, by_order: Floats) -> tuple[float, float]:
    """Coefficients that the angles phi of a grid may not resolve, and what they alias onto averages.

    What turns fast in theta may turn as fast in phi.  Averages see what turns twice as fast as the angles phi
    resolve, and squares of the rest.  But all of it counts where few orders in phi are there: nothing is seen
    of how they fall, and symmetry aliases orders onto one another.
    """
    m = len(by_order)
    if m == 1:
        return 0.0, 0.0
    unseen = float(by_degree[m:].max(initial=0.0))
    if not np.any(by_order[1:] > SYMMETRIC):
        return unseen, _beyond(by_degree, 2 * m - 2)
    if np.count_nonzero(by_order[1:] > SYMMETRIC) < 3:  # too few orders show how they fall
        return unseen, unseen
    return unseen, max(float(by_degree[2 * m - 2 :].max(initial=0.0)), m * unseen**2)


def _beyond(values: Floats, degree: int) -> float:
    """The largest coefficient from a degree on, extrapolated from the end if that is beyond."""
    n = len(values)
    if degree < n:
        return float(values[degree:].max())
    return _end(values) * _fall(values, n) ** ((degree - n) / n)


def _noise(size: Floats) -> float:
    """Noise in coefficients (n, m, c): where a function of the grid's degree has none.

    Without angles phi that is one parity in theta, where the function is symmetric about the equator; else
    noise is no larger than what the fall ends with.
    """
    n, m, _ = size.shape
    if m == 1:
        by_degree = size.max(axis=(1, 2))
        certain = n >= 12 and _geometric(by_degree) > 0.0  # of fewer numbers, noise may look so
        high = by_degree[-2 if certain else -max(4, n // 4) :]
        return float(min(high[::2].max(), high[1::2].max())) if n > 2 else np.inf
    far = (np.arange(n)[:, None] / n) ** 2 + (np.arange(m) / m) ** 2
    # Coefficients of largest k^2 and m^2 are noise alone.
    outermost = far >= np.sort(far, axis=None)[-max(2, far.size // 100)]
    return float(np.sqrt(np.mean(size[outermost] ** 2, axis=0).max()))


def _scatter(size: Floats) -> float:
    """Standard deviation at a point of noise like the highest degrees of coefficients (n, m, c)."""
    n, m, _ = size.shape
    high = np.zeros((n, m), dtype=bool)
    high[n - _share(END if m > 1 else 0.25, n) :] = True  # with one angle phi there are few coefficients
    if m > 1:
        high[:, m - _share(END, m) :] = True
    return float(np.sqrt(n * m * np.mean(size[high] ** 2, axis=0).max()))
