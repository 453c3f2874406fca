"""Truncation error of grid data, by coarsening.

The interpolant of a grid is sampled on grids with fewer nodes of the same kind, and these interpolants are
averaged as the first one is.  The changes are the errors of the coarser grids.  That of the grid itself is
extrapolated: errors fall geometrically where the functions are analytic.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from isoembed.arrays import Floats
from isoembed.meshing.sphere import directions_at
from isoembed.smooth.double_fourier import DoubleFourier, is_legendre
from isoembed.smooth.harmonics import Harmonics

Derived = Callable[[Floats], Floats]

WEIGHTS = Harmonics(2, 2)
"""Weights of the averages; those of each degree count half as much as those of the degree below."""


def truncation(series: DoubleFourier, derived: Derived) -> float:
    """Estimate of the error of averages over the sphere with smooth weights, because the grid is finite.

    Coefficients beyond the grid that alias onto averages directly, as those of twice its degree do, are not
    on the coarser grids either, and not in the estimate.

    Parameters
    ----------
    series : DoubleFourier
    derived : callable
        Takes values (k, c) of the functions at points and returns (k, j): the functions to be averaged.

    Returns
    -------
    float
        In the unit of the derived functions.
    """
    n = len(series.theta)
    finest = _averages(series, derived, n)
    # A fifth of the nodes is left out in each step.  Parity hides every other change.
    step = max(1 if n < 6 else 2, round(0.2 * n))
    changes = [
        max(
            float(np.linalg.norm(_averages(_coarser(series, less), derived, n) - finest))
            for less in {min(part * step + odd, n - 1) for odd in (0, 1)}
        )
        for part in range(1, 4 if n >= 12 else 3)  # grids with few nodes tell no rate
    ]
    ratio = max(less / more if less < more else 1.0 for less, more in pairwise(changes))
    # The sum over all further steps, at most 10/3 of the first.
    return changes[0] * ratio / max(1.0 - ratio, 0.3)


def _averages(series: DoubleFourier, derived: Derived, n: int) -> Floats:
    """Averages (size, j) of the derived functions with the weights, for a grid of n rows of nodes."""
    z, across = legendre.leggauss(3 * n // 2 + 3)  # for products, too
    m = len(series.phi)
    around = 2 * m if m > 1 else 6
    phi: Floats = np.arange(around, dtype=np.float64) * (2.0 * np.pi / around)
    u = directions_at(z[:, None], phi).reshape(-1, 3)
    weights = np.repeat(across / (2.0 * len(phi)), len(phi))[:, None] * WEIGHTS.values(u)
    weights *= 0.5 ** WEIGHTS.labels[0] * np.sqrt(4.0 * np.pi)
    theta: Floats = np.asarray(np.arccos(z), dtype=np.float64)
    values = derived(series.on(theta, phi).reshape(len(u), -1))
    return np.asarray(weights.T @ values, dtype=np.float64)


def _coarser(series: DoubleFourier, less: int) -> DoubleFourier:
    """Series sampled on a smaller number of rows of nodes, and on fewer angles phi in proportion."""
    n, m = len(series.theta), len(series.phi)
    rows = n - less
    if is_legendre(series.theta):
        theta = np.asarray(np.arccos(legendre.leggauss(rows)[0])[::-1], dtype=np.float64)
    else:
        first = series.theta[0] / (series.theta[1] - series.theta[0])  # in steps
        theta = (first + np.arange(rows)) * (np.pi / (rows - 1 + 2.0 * first))
    around = max(1, round(m * rows / n))
    phi: Floats = series.phi[0] + np.arange(around) * (2.0 * np.pi / around)
    return DoubleFourier(theta, phi, series.on(theta, phi))
