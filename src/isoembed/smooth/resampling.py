"""Truncation error of grid data, by coarsening.

The interpolant of a grid is sampled on coarser grids of the same kind, and averages of these interpolants are
compared.  The changes are the errors of the coarser grids, from which that of the grid itself is
extrapolated: errors decrease geometrically for analytic functions.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import directions_at, gauss_legendre
from isoembed.smooth.double_fourier import DoubleFourier, is_legendre
from isoembed.smooth.harmonics import Harmonics

Derived = Callable[[Floats], Floats]

WEIGHTS = Harmonics(2, 2)
"""Weight functions of the averages; each degree counts half as much as the one below."""


def truncation(series: DoubleFourier, derived: Derived) -> float:
    """Estimate of the truncation error of averages over the sphere with smooth weights.

    Unresolved coefficients that alias directly onto averages, such as those of twice the degree of the grid,
    are not included, because the coarser grids lack them, too.

    Parameters
    ----------
    series : DoubleFourier
    derived : callable
        Takes values (k, c) of the functions at points and returns the functions (k, j) to be averaged.

    Returns
    -------
    float
        Error, in the unit of the derived functions.
    """
    n = len(series.theta)
    finest = _averages(series, derived, n)
    # Each step omits a fifth of the nodes.  Parity may hide every other change.
    step = max(1 if n < 6 else 2, round(0.2 * n))
    changes = [
        max(
            float(np.linalg.norm(_averages(_coarser(series, less), derived, n) - finest))
            for less in {min(part * step + odd, n - 1) for odd in (0, 1)}
        )
        for part in range(1, 4 if n >= 12 else 3)  # few nodes do not determine a rate
    ]
    ratio = max(less / more if less < more else 1.0 for less, more in pairwise(changes))
    # Geometric series over all further refinements, with a sum of at most 10/3 of its first term.
    return changes[0] * ratio / max(1.0 - ratio, 0.3)


def _averages(series: DoubleFourier, derived: Derived, n: int) -> Floats:
    """Averages (size, j) of the derived functions with the weights, for a grid of n rows of nodes."""
    z, across = gauss_legendre(3 * n // 2 + 3)  # for products, too
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
        theta = np.asarray(np.arccos(gauss_legendre(rows)[0])[::-1], dtype=np.float64)
    else:
        first = series.theta[0] / (series.theta[1] - series.theta[0])  # in steps
        theta = (first + np.arange(rows)) * (np.pi / (rows - 1 + 2.0 * first))
    around = max(1, round(m * rows / n))
    phi: Floats = series.phi[0] + np.arange(around) * (2.0 * np.pi / around)
    return DoubleFourier(theta, phi, series.on(theta, phi))
