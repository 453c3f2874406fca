"""Double-exponential quadrature, and adaptive refinement of quadrature rules."""

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats

COARSEST = 48  # nodes of the first rule


def tanh_sinh(n: int) -> tuple[Floats, Floats]:
    """Nodes and weights (n,) on [0, pi/2].

    The nodes crowd doubly exponentially at both ends, so that integrands which are not smooth there,
    or nearly singular just beyond (the tips of an ergosphere), converge exponentially all the same.

    References
    ----------
    H. Takahasi and M. Mori, "Double exponential formulas for numerical integration" (1974).
    """
    t, step = np.linspace(-3.4, 3.4, n, retstep=True)
    rest = np.exp(-np.pi * np.sinh(t))
    x = 1.0 / (1.0 + rest)
    return 0.5 * np.pi * x, 0.5 * np.pi * float(step) * np.pi * np.cosh(t) * x * (rest / (1.0 + rest))


def integrate(integrand: Callable[[int], Floats]) -> Floats:
    """Integrals with more and more nodes, until they settle to rounding.

    Parameters
    ----------
    integrand
        Maps a number of nodes to the vector of integrals it gives.
    """
    n, value = COARSEST, integrand(COARSEST)
    while n < 768:  # nodes: the integral of such a rule is returned as it is
        n, last = 2 * n, value
        value = integrand(n)
        if np.all(np.abs(value - last) <= 3e-14 * np.abs(value)):  # the change is rounding
            break
    return value
