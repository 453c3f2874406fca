"""Preconditioned conjugate gradients, which say how far they came."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Operator = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Approximation:
    """An approximate solution of A x = b.

    Attributes
    ----------
    x : ndarray
    residual : float
        The norm of ``b - A x``, as the iteration updates it, relative to that of b.
    iterations : int
    """

    x: Floats
    residual: float
    iterations: int


def conjugate_gradients(
    apply: Operator, precondition: Operator, b: Floats, tolerance: float, most: int
) -> Approximation:
    """Solve A x = b for A symmetric and positive semidefinite, b in its range.

    Parameters
    ----------
    apply, precondition : callable
        ``A v`` and an approximation of ``A^-1 v``, symmetric and positive definite, for v of the shape of b.
    b : ndarray
        Of any shape.
    tolerance : float
        Of the residual's norm, relative to that of b.
    most : int
        Iterations.

    Returns
    -------
    Approximation
        It ends before the tolerance is reached where rounding spoils a direction.

    References
    ----------
    Y. Saad, Iterative methods for sparse linear systems, 2003, algorithm 9.1.
    """
    x, r = np.zeros_like(b), b.copy()
    size = float(np.linalg.norm(b))
    residual, iterations = 1.0 if size else 0.0, 0
    p, rz = np.zeros_like(b), 1.0
    while residual > tolerance and iterations < most:
        z = precondition(r)
        before, rz = rz, float(np.vdot(r, z))
        p *= rz / before
        p += z
        q = apply(p)
        curvature = float(np.vdot(p, q))
        if not (curvature > 0 and rz > 0):
            break
        alpha = rz / curvature
        x += alpha * p
        r -= alpha * q
        residual = float(np.linalg.norm(r)) / size
        iterations += 1
    return Approximation(x, residual, iterations)
