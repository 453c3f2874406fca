"""Error estimates of grid functions from their Fourier coefficients.

The coefficients of a smooth function decay with their degree, those of noise do not.  Truncated coefficients
are estimated from the highest resolved degrees.  Averages over the sphere are more accurate than values at
points: they are affected only by aliasing onto degree zero, from about twice the highest degree.  The decay
is extrapolated so far only if noise is excluded: a function of degree l has no coefficients k in theta and m
in phi with k^2 + m^2 > l^2, so that this corner of the spectrum contains only noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.smooth.double_fourier import DoubleFourier
from isoembed.smooth.resampling import Derived, truncation
from isoembed.smooth.uncertain import Uncertainty

END = 0.1  # fraction of the degrees that count as the highest
FEWEST = 2  # least number of highest degrees, as some vanish by symmetry
SYMMETRIC = 1e-12  # largest relative dependence on phi that counts as zero
SCATTER = 4.0  # largest error at a point in standard deviations


@dataclass(frozen=True)
class Spectrum:
    """Errors of functions from their Fourier coefficients, in the unit of the functions.

    Attributes
    ----------
    largest : float
        Largest coefficient.
    tail : float
        Largest coefficient of the highest degrees in theta or phi.  Degrees in theta beyond the resolution in
        phi count as high, because the function may vary as fast in phi.
    unseen : float
        Largest coefficient of those degrees in theta.
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
            Takes values (k, c) of the functions, relative to their largest coefficient, and returns functions
            (k, j) of them in the same unit, whose averages the error covers; by default the functions.
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
    """Largest coefficient of the highest degrees."""
    return float(values[-_share(END, len(values)) :].max())


def _fall(values: Floats, samples: int) -> float:
    """Estimated sum of the coefficients beyond degree 2 n, relative to the last of n.

    A geometric decay is extrapolated.  Otherwise half the rate of decay before n is assumed, where each value
    is a maximum over samples, and the slower decay of a narrow and a wide band counts.
    """
    n = len(values)
    rate = _rate(values)
    if rate > 0.0:
        return float(np.exp(-0.9 * rate * n))  # safety factor on the rate
    is_determined = n >= 8  # fewer coefficients do not determine the decay
    factor = 4.0 ** (-0.5 * n)  # fastest decay that is assumed
    # From one degree to the next if both parities occur, for functions that end before the grid does.
    for last, before in zip(values[:-3:-1], values[-2:-4:-1], strict=False):
        if SYMMETRIC < last < before:
            factor = max(factor, float(last / before) ** (0.5 * n))
    for width in {FEWEST, _share(0.125, n)}:
        if n < 2 * width:
            return 1.0
        last, before = float(values[-width:].max()), float(values[-2 * width : -width].max())
        # Statistical fluctuation of the largest coefficient.
        chance = 1.0 + 2.0 / np.sqrt(width * samples) if is_determined else 1.0
        ratio = min(1.0, chance * last / before) if before > 0.0 else 1.0
        factor = max(factor, ratio ** (n / (2.0 * width)))
    return 3.0 * factor if is_determined else factor  # ratio of the sum to the largest


def _rate(values: Floats) -> float:
    """Logarithmic decay of coefficients (n,) per degree, if it is geometric; otherwise 0."""
    # Every other coefficient may be small by parity.
    pairs = np.maximum.reduceat(values, np.arange(0, len(values), 2))
    both = min(values[::2].max(), values[1::2].max(initial=0.0)) > SYMMETRIC
    return max(0.5 * _geometric(pairs), _geometric(values) if both else 0.0)


def _geometric(values: Floats) -> float:
    """Logarithmic decay from one of the values (n,) to the next, if it is geometric; otherwise 0.

    For kinks coefficients decay algebraically, at a decreasing rate; noise ends any decay.
    """
    envelope = np.maximum.accumulate(values[::-1])[::-1]
    at = np.unique(np.linspace(len(values) // 5, len(values) - 1, 4).astype(int))
    if len(at) < 4 or envelope[-1] <= 0.0:
        return 0.0
    falls = -np.diff(np.log(envelope[at])) / np.diff(at)
    return float(falls.min()) if np.all(falls[1:] > 0.8 * falls[:-1]) else 0.0


def _unseen(by_degree: Floats, by_order: Floats) -> tuple[float, float]:
    """Coefficients possibly not resolved by the angles phi of a grid, and their aliasing onto averages.

    Degrees that occur in theta may occur as orders in phi.  Averages are affected by orders twice as high as
    the angles phi resolve, and by squares of the others.  With few nonzero orders all of them count, because
    their decay is unknown, and symmetry aliases orders onto one another.
    """
    m = len(by_order)
    if m == 1:
        return 0.0, 0.0
    unseen = float(by_degree[m:].max(initial=0.0))
    if not np.any(by_order[1:] > SYMMETRIC):
        return unseen, _beyond(by_degree, 2 * m - 2)
    if np.count_nonzero(by_order[1:] > SYMMETRIC) < 3:  # too few orders to determine a decay
        return unseen, unseen
    return unseen, max(float(by_degree[2 * m - 2 :].max(initial=0.0)), m * unseen**2)


def _beyond(values: Floats, degree: int) -> float:
    """Largest coefficient from a degree on, extrapolated if the degree is beyond the grid."""
    n = len(values)
    if degree < n:
        return float(values[degree:].max())
    return _end(values) * _fall(values, n) ** ((degree - n) / n)


def _noise(size: Floats) -> float:
    """Noise in coefficients (n, m, c), from those that vanish for functions of the degree of the grid.

    With one angle phi these are one parity in theta, for functions symmetric about the equator; otherwise
    noise is at most the end of the decay.
    """
    n, m, _ = size.shape
    if m == 1:
        by_degree = size.max(axis=(1, 2))
        certain = n >= 12 and _geometric(by_degree) > 0.0  # fewer numbers may be geometric by chance
        high = by_degree[-2 if certain else -max(4, n // 4) :]
        return float(min(high[::2].max(), high[1::2].max())) if n > 2 else np.inf
    far = (np.arange(n)[:, None] / n) ** 2 + (np.arange(m) / m) ** 2
    # Coefficients of largest k^2 + m^2 are pure noise.
    outermost = far >= np.sort(far, axis=None)[-max(2, far.size // 100)]
    return float(np.sqrt(np.mean(size[outermost] ** 2, axis=0).max()))


def _scatter(size: Floats) -> float:
    """Pointwise standard deviation of noise of the size of the highest degrees of coefficients (n, m, c)."""
    n, m, _ = size.shape
    high = np.zeros((n, m), dtype=bool)
    high[n - _share(END if m > 1 else 0.25, n) :] = True  # with one angle phi there are few coefficients
    if m > 1:
        high[:, m - _share(END, m) :] = True
    return float(np.sqrt(n * m * np.mean(size[high] ** 2, axis=0).max()))
