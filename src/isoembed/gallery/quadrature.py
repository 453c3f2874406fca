"""Quadrature: the double-exponential rule, and any rule with more and more nodes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class IntegralThresholds:
    """Thresholds of integrals over closed forms."""

    coarsest: int = threshold(48, "nodes", "Of the first rule.")
    finest: int = threshold(768, "nodes", "The integral of a rule with so many is returned as it is.")
    settled: float = threshold(3e-14, "relative", "Change that is rounding when the nodes are doubled.")


INTEGRALS = IntegralThresholds()


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
    n, value = INTEGRALS.coarsest, integrand(INTEGRALS.coarsest)
    while n < INTEGRALS.finest:
        n, last = 2 * n, value
        value = integrand(n)
        if np.all(np.abs(value - last) <= INTEGRALS.settled * np.abs(value)):
            break
    return value
