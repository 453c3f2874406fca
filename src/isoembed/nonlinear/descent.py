"""Descent: from point to point along curves, by an acceptance rule, until a stopping rule holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

import numpy as np

from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import Acceptance
from isoembed.nonlinear.stopping import Stop, never

P = TypeVar("P")
Curve = Callable[[float], P | None]


class Reason(Enum):
    """Why an iteration ended."""

    CONVERGED = "the stopping rule holds"
    STALLED = "the value is at its rounding errors, or grows without bound"
    REJECTED = "no point of the step's curve is acceptable"
    SINGULAR = "the matrix of the step is singular"
    EXHAUSTED = "the iterations, or what may be spent, are used up"


@dataclass(frozen=True, eq=False)
class Solution(Generic[P]):
    """Where an iteration ended.

    Attributes
    ----------
    point : P
        The last one.
    value : float
    best : P
        The one of least value; another one only after steps that were free to raise it.
    least : float
        Its value.
    reason : Reason
    iterations : int
        Accepted steps.
    """

    point: P
    value: float
    best: P
    least: float
    reason: Reason
    iterations: int

    @property
    def converged(self) -> bool:
        """Whether the stopping rule holds."""
        return self.reason is Reason.CONVERGED


def descend(
    start: P,
    step: Callable[[P], Curve[P] | None],
    acceptance: Acceptance,
    *,
    value: Callable[[P], float],
    converged: Stop,
    max_iterations: int,
    stalled: Stop = never,
    exhausted: Callable[[P], bool] = never,
) -> Solution[P]:
    """Lower a value step by step.

    Parameters
    ----------
    start : P
    step : callable
        The curve of a step from a point: takes a fraction or a damping, as the acceptance rule does, and
        returns a point, or None where there is none.  None instead of a curve where there is no step.  Both
        may raise SingularMatrix: `step` to end the iteration, the curve to have another parameter tried.
    acceptance : LineSearch or Damping
    value : callable
        The norm of the residual, or an energy.
    converged, stalled : callable
        Stopping rules (`isoembed.nonlinear.stopping`), tested at each point.
    max_iterations : int
    exhausted : callable
        Whether no more may be spent, asked with the point before each trial.

    Returns
    -------
    Solution
    """
    best = point = start
    least, size, before, parameter = np.inf, value(start), np.inf, acceptance.first
    for iteration in range(max_iterations + 1):
        if size < least:
            best, least = point, size
        if converged(point, size, before):
            reason = Reason.CONVERGED
        elif stalled(point, size, before):
            reason = Reason.STALLED
        elif iteration == max_iterations:
            reason = Reason.EXHAUSTED
        else:
            found = _accepted(point, size, parameter, step, acceptance, value, exhausted)
            if not isinstance(found, Reason):
                before = least
                point, size, parameter = found
                continue
            reason = found
        break
    return Solution(point, size, best, least, reason, iteration)


def _accepted(
    point: P,
    size: float,
    first: float,
    step: Callable[[P], Curve[P] | None],
    acceptance: Acceptance,
    value: Callable[[P], float],
    exhausted: Callable[[P], bool],
) -> tuple[P, float, float] | Reason:
    """The next point, its value, and the parameter with which the step after it begins."""
    try:
        curve = step(point)
    except SingularMatrix:
        return Reason.SINGULAR
    if curve is None:
        return Reason.STALLED
    for parameter in acceptance.parameters(first):
        if exhausted(point):
            return Reason.EXHAUSTED
        try:
            trial = curve(parameter)
        except SingularMatrix:
            continue
        if trial is None:
            continue
        reached = value(trial)
        if acceptance.accepts(reached, size, parameter):
            return trial, reached, acceptance.following(reached, size, parameter)
    return Reason.REJECTED
