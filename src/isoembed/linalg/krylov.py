"""Krylov methods: flexible GMRES, and preconditioned conjugate gradients."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats

Operator = Callable[[Floats], Floats]


def gmres(
    apply: Operator, precondition: Operator, b: Floats, tolerance: float, most: int
) -> tuple[Floats, int]:
    """Solve A x = b to a relative residual, preconditioned from the right.

    Where a preconditioner costs as much as a factor's solve, the extra ones that library routines spend on
    starting and ending count: this one spends none.  Several right-hand sides are solved side by side, each
    in a space of its own, because a factor solves several at once in less time than one by one.

    Parameters
    ----------
    apply, precondition : callable
        ``A v`` and an approximation of ``A^-1 v``, for v of the shape of b.
    b : ndarray, shape (n,) or (n, k)
    tolerance : float
        Of the residual's norm, relative to that of b; of each column.
    most : int
        Iterations after which the best solution so far is returned.

    Returns
    -------
    ndarray, int
        The solution, of the shape of b, and the iterations made.

    References
    ----------
    Y. Saad, A flexible inner-outer preconditioned GMRES algorithm, SIAM J. Sci. Comput. 14 (1993).
    """
    size = np.sqrt(_products(b, b))
    if not size.any():
        return np.zeros_like(b), 0
    columns = 1 if b.ndim == 1 else b.shape[1]
    v = b / np.where(size > 0, size, 1.0)
    basis, directions = [v], []
    H = np.zeros((columns, most + 1, most))
    y = np.zeros((columns, 0))
    for k in range(most):
        directions.append(precondition(v))
        w = apply(directions[k])
        # The modified Gram-Schmidt process: one vector of the basis at a time.
        for i, q in enumerate(basis):
            products = _products(q, w)
            H[:, i, k] = products
            w -= products * q
        norm = np.sqrt(_products(w, w))
        H[:, k + 1, k] = norm
        y, missing = _least_squares(H[:, : k + 2, : k + 1], np.atleast_1d(size))
        if ((missing <= tolerance * size) | (norm == 0)).all():
            break
        v = w / np.where(norm > 0, norm, 1.0)
        basis.append(v)
    x = np.zeros_like(b)
    for k, direction in enumerate(directions):
        x += y[:, k].reshape(size.shape) * direction
    return x, len(directions)


def _products(v: Floats, w: Floats) -> Floats:
    """Inner products of vectors, or of columns."""
    return np.asarray(np.einsum("i...,i...->...", v, w))


def _least_squares(H: Floats, sizes: Floats) -> tuple[Floats, Floats]:
    """Least-squares solutions y of ``H y = size e_1`` for each H of (k, m + 1, m), and their residuals."""
    y, missing = np.zeros((len(H), H.shape[2])), np.zeros(len(H))
    for c, matrix in enumerate(H):
        aim = np.zeros(len(matrix))
        aim[0] = sizes[c]
        y[c] = np.linalg.lstsq(matrix, aim, rcond=None)[0]
        missing[c] = np.linalg.norm(aim - matrix @ y[c])
    return y, missing


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
    apply: Operator,
    precondition: Operator,
    b: Floats,
    tolerance: float,
    most: int,
    *,
    patience: int | None = None,
) -> Approximation:
    """Solve A x = b for A symmetric and positive semidefinite, b of any shape and in its range.

    The parameters are those of `gmres`; the preconditioner must be symmetric and positive definite, and must
    not change.  It ends before the tolerance is reached where rounding spoils a direction, and, from
    `patience` iterations on, where `most` of them would not reach it at the mean rate so far.

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
        if patience is not None and iterations >= patience and residual > tolerance ** (iterations / most):
            break
    return Approximation(x, residual, iterations)
