"""Quadrature: double-exponential over [0, pi/2] where a surface is symmetric, else over the whole sphere."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def tanh_sinh(n: int) -> tuple[Array, Array]:
    """Return n nodes and weights on [0, pi/2].

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


def sphere_rule(n: int) -> tuple[Array, Array]:
    """Return 2 n^2 nodes (unit vectors) and weights on the unit sphere, exact below degree 2 n.

    Gauss-Legendre nodes along x and even angles around it: integrands that are analytic on the sphere
    converge exponentially. The pole is the x-axis because the bodies that are long are long in x.
    """
    x, w = np.polynomial.legendre.leggauss(n)
    phi = np.pi / n * np.arange(2 * n)
    sin = np.sqrt((1.0 - x) * (1.0 + x))
    y, z = np.outer(sin, np.cos(phi)), np.outer(sin, np.sin(phi))
    u = np.stack([np.repeat(x, 2 * n), y.ravel(), z.ravel()], axis=1)
    return u, np.repeat(np.pi / n * w, 2 * n)


def integrate(integrand: Callable[[int], Array], coarsest: int = 48, finest: int = 768) -> Array:
    """Double the nodes until the vector of integrals settles to rounding.

    Parameters
    ----------
    integrand
        Maps a number of nodes to the vector of integrals it gives.
    coarsest, finest
        The first number of nodes, and the one at which the best value so far is returned as it is.
    """
    n, value = coarsest, integrand(coarsest)
    while n < finest:
        n, last = 2 * n, value
        value = integrand(n)
        if np.all(np.abs(value - last) <= 3e-14 * np.abs(value)):
            break
    return value
