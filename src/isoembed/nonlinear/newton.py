"""Newton's method and the Gauss-Newton method on arrays: residual, linear solve, step.

Newton's method solves ``J d = r`` for the step ``x - d``.  Where there are more equations than unknowns, d is
the solution of least squares (Gauss and Newton); where there are fewer, that of least norm.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import FULL_STEPS, Acceptance
from isoembed.nonlinear.descent import Curve, Solution, descend
from isoembed.nonlinear.stopping import Stop, never


class Point(NamedTuple):
    """Unknowns, their residual, and the most by which one changed in the last step, infinite at the start."""

    x: Floats
    residual: Floats
    moved: float = np.inf


def largest(point: Point) -> float:
    """The largest absolute value in the residual."""
    return float(np.abs(point.residual).max())


def newton(
    start: Floats,
    residual: Callable[[Floats], Floats],
    solve: Callable[[Floats, Floats], Floats],
    acceptance: Acceptance = FULL_STEPS,
    *,
    converged: Stop,
    max_iterations: int,
    stalled: Stop = never,
    norm: Callable[[Point], float] = largest,
) -> Solution[Point]:
    """Solve ``residual(x) = 0``, or its least squares, near a start.

    Parameters
    ----------
    start : ndarray
    residual : callable
        Takes x; the residual has any shape.
    solve : callable
        Takes x and its residual, and returns the d of the step ``x - d``; may raise SingularMatrix.
    acceptance : LineSearch
        Whole steps by default.
    converged, stalled : callable
        Stopping rules.
    max_iterations : int
    norm : callable
        Of a point: by default its largest residual.
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
