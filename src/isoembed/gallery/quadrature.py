"""Double-exponential quadrature, and adaptive refinement of quadrature rules."""

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats


def tanh_sinh(n: int) -> tuple[Floats, Floats]:
    """Nodes and weights (n,) on [0, pi/2].

    The nodes cluster doubly exponentially at both ends, so that integrals converge exponentially even if the
    integrand is not smooth there, or nearly singular just beyond (at the tips of an ergosphere).

    References
    ----------
    H. Takahasi and M. Mori, "Double exponential formulas for numerical integration" (1974).
    """
    t, step = np.linspace(-3.4, 3.4, n, retstep=True)
    rest = np.exp(-np.pi * np.sinh(t))
    x = 1.0 / (1.0 + rest)
    return 0.5 * np.pi * x, 0.5 * np.pi * float(step) * np.pi * np.cosh(t) * x * (rest / (1.0 + rest))


def integrate(integrand: Callable[[int], Floats]) -> Floats:
    """Evaluate integrals with increasing numbers of nodes, until they converge to rounding.

    Parameters
    ----------
    integrand
        Maps a number of nodes to a vector of integrals.
    """
    n = 48  # nodes of the first rule
    value = integrand(n)
    while n < 768:  # limit of nodes; the last value is returned without convergence
        n, last = 2 * n, value
        value = integrand(n)
        if np.all(np.abs(value - last) <= 3e-14 * np.abs(value)):  # converged to rounding
            break
    return value
