"""Newton's method and the Gauss-Newton method on arrays: residual, linear solve, step.

Newton's method solves ``J d = r`` for the step ``x - d``.  If there are more equations than unknowns, d is
the least-squares solution (Gauss-Newton); if there are fewer, the minimum-norm solution.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import FULL_STEPS, LineSearch
from isoembed.nonlinear.descent import Curve, Solution, descend
from isoembed.nonlinear.stopping import Stop, never


class Point(NamedTuple):
    """Unknowns, their residual, and the largest change in the last step (infinite at the start)."""

    x: Floats
    residual: Floats
    moved: float = np.inf


def largest(point: Point) -> float:
    """Maximum absolute value of the residual."""
    return float(np.abs(point.residual).max(initial=0.0))


def newton(
    start: Floats,
    residual: Callable[[Floats], Floats],
    solve: Callable[[Floats, Floats], Floats],
    acceptance: LineSearch = FULL_STEPS,
    *,
    converged: Stop,
    max_iterations: int,
    stalled: Stop = never,
    norm: Callable[[Point], float] = largest,
) -> Solution[Point]:
    """Solve ``residual(x) = 0``, exactly or in least squares, near a starting point.

    Parameters
    ----------
    start : ndarray
    residual : callable
        Takes x.
    solve : callable
        Takes x and its residual, and returns the d of the step ``x - d``; may raise SingularMatrix.
    acceptance, converged, stalled, max_iterations
        See `descend`.
    norm : callable
        Value of a point.
    """

    def step(p: Point) -> Curve[Point]:
        d = solve(p.x, p.residual)
        longest = float(np.abs(d).max())

        def at(fraction: float) -> Point:
            x = p.x - fraction * d
            return Point(x, residual(x), fraction * longest)

        return at

    return descend(
        Point(start, residual(start)),
        step,
        acceptance,
        value=norm,
        converged=converged,
        stalled=stalled,
        max_iterations=max_iterations,
    )


def damped_step(hessian: Floats, gradient: Floats, damping: float) -> Floats:
    """Levenberg-Marquardt step d, ``(H + damping I) d = g``; raises LinAlgError."""
    matrix = hessian.copy()
    matrix[np.diag_indices(len(matrix))] += damping
    factor = cho_factor(matrix, overwrite_a=True, check_finite=False)
    return np.asarray(cho_solve(factor, gradient, check_finite=False))
