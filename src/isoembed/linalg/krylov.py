"""Flexible GMRES: one product and one preconditioner solve an iteration, and nothing more."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Operator = Callable[[Floats], Floats]


def gmres(
    apply: Operator, precondition: Operator, b: Floats, tolerance: float, most: int
) -> tuple[Floats, int]:
    """Solve A x = b to a relative residual, preconditioned from the right.

    Where a preconditioner costs as much as a factor's solve, the extra ones that library routines spend on
    starting and ending count: this one spends none.

    Parameters
    ----------
    apply, precondition : callable
        ``A v`` and an approximation of ``A^-1 v``.
    b : ndarray, shape (n,)
    tolerance : float
        Of the residual's norm, relative to that of b.
    most : int
        Iterations after which the best solution so far is returned.

    Returns
    -------
    ndarray, int
        The solution, and the iterations made.

    References
    ----------
    Y. Saad, A flexible inner-outer preconditioned GMRES algorithm, SIAM J. Sci. Comput. 14 (1993).
    """
    size = float(np.linalg.norm(b))
    if size == 0:
        return np.zeros_like(b), 0
    basis, directions = np.empty((most + 1, b.size)), np.empty((most, b.size))
    basis[0] = b / size
    H = np.zeros((most + 1, most))
    y: Floats = np.zeros(0)
    for k in range(most):
        directions[k] = precondition(basis[k])
        w = apply(directions[k])
        H[: k + 1, k] = basis[: k + 1] @ w
        w -= H[: k + 1, k] @ basis[: k + 1]
        H[k + 1, k] = np.linalg.norm(w)
        rhs = np.zeros(k + 2)
        rhs[0] = size
        y = np.linalg.lstsq(H[: k + 2, : k + 1], rhs, rcond=None)[0].astype(np.float64)
        residual = float(np.linalg.norm(rhs - H[: k + 2, : k + 1] @ y))
        if residual <= tolerance * size or H[k + 1, k] == 0:
            break
        basis[k + 1] = w / H[k + 1, k]
    return y @ directions[: y.size], y.size
