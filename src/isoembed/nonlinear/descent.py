"""Descent loop with exchangeable step, acceptance rule and stopping rule; failed steps are shortened."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from itertools import count
from typing import Generic, TypeVar

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import Damping, LineSearch
from isoembed.nonlinear.stopping import Stop, never

P = TypeVar("P")
Curve = Callable[[float], P | None]
NO_POINT = SingularMatrix, np.linalg.LinAlgError, InvalidMetric, InvalidParameter


class Reason(Enum):
    """Reason for the end of an iteration."""

    CONVERGED = "the stopping rule holds"
    STALLED = "only rounding errors remain, or the value diverges"
    REJECTED = "no point of the step's curve is acceptable"
    SINGULAR = "the matrix of the step is singular"
    EXHAUSTED = "the limit of iterations or cost is reached"


@dataclass(frozen=True, eq=False)
class Solution(Generic[P]):
    """Result of an iteration.

    Attributes
    ----------
    point, value
        Last point.
    best, best_value
        Point with the smallest value, which differs from the last one only after `FULL_STEPS`.
    reason : Reason
    iterations : int
        Number of accepted steps.
    """

    point: P
    value: float
    best: P
    best_value: float
    reason: Reason
    iterations: int

    @property
    def converged(self) -> bool:
        """Whether the stopping rule holds."""
        return self.reason is Reason.CONVERGED


def descend(
    start: P,
    step: Callable[[P], Curve[P]],
    acceptance: LineSearch | Damping,
    *,
    value: Callable[[P], float],
    converged: Stop,
    max_iterations: int,
    stalled: Stop = never,
    exhausted: Callable[[P], bool] = never,
    max_trials: float = np.inf,
) -> Solution[P]:
    """Minimize a value iteratively.

    Parameters
    ----------
    start : P
    step : callable
        Takes a point and returns the curve of a step: a callable that takes a fraction or a damping,
        according to the acceptance rule, and returns a point.  If there is none it returns None or raises
        SingularMatrix, LinAlgError, InvalidMetric or InvalidParameter, and another parameter is tried.  A
        SingularMatrix raised by `step` itself ends the iteration.
    acceptance : LineSearch or Damping
    value : callable
        Norm of the residual at a point, or an energy.
    converged, stalled : callable
        Stopping rules, applied at each point.
    max_iterations : int
    exhausted : callable
        Whether the budget is used up, called with the point before each trial.
    max_trials : float
        Maximum number of trials in all iterations.
    """
    best = point = start
    best_value, size, before, parameter = np.inf, value(start), np.inf, acceptance.first
    trials = count()

    def accepted() -> tuple[P, float, float] | Reason:
        try:
            curve = step(point)
        except SingularMatrix:
            return Reason.SINGULAR
        for tried in acceptance.parameters(parameter):
            if exhausted(point) or next(trials) >= max_trials:
                return Reason.EXHAUSTED
            try:
                trial = curve(tried)
            except NO_POINT:
                continue
            if trial is not None and acceptance.accepts(reached := value(trial), size, tried):
                return trial, reached, acceptance.following(reached, size, tried)
        return Reason.REJECTED

    for iteration in range(max_iterations + 1):
        if size < best_value:
            best, best_value = point, size
        if converged(point, size, before):
            reason = Reason.CONVERGED
        elif stalled(point, size, before):
            reason = Reason.STALLED
        elif iteration == max_iterations:
            reason = Reason.EXHAUSTED
        elif isinstance(found := accepted(), Reason):
            reason = found
        else:
            before = best_value
            point, size, parameter = found
            continue
        break
    return Solution(point, size, best, best_value, reason, iteration)
