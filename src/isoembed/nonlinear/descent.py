"""Descent loop with exchangeable step, acceptance rule and stopping rule."""

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
        The last point.
    best, least
        The point of least value: another one only after `FULL_STEPS`.
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
        The curve of a step from a point: it takes a fraction or a damping, as the acceptance rule does, and
        returns a point.  Where there is none it returns None or raises SingularMatrix, LinAlgError,
        InvalidMetric or InvalidParameter, and another parameter is tried.  A SingularMatrix that is raised by
        `step` itself ends the iteration.
    acceptance : LineSearch or Damping
    value : callable
        The norm of the residual at a point, or an energy.
    converged, stalled : callable
        Stopping rules, applied at each point.
    max_iterations : int
    exhausted : callable
        Whether no more may be spent, asked with the point before each trial.
    max_trials : float
        Of all iterations together.
    """
    best = point = start
    least, size, before, parameter = np.inf, value(start), np.inf, acceptance.first
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
        if size < least:
            best, least = point, size
        if converged(point, size, before):
            reason = Reason.CONVERGED
        elif stalled(point, size, before):
            reason = Reason.STALLED
        elif iteration == max_iterations:
            reason = Reason.EXHAUSTED
        elif isinstance(found := accepted(), Reason):
            reason = found
        else:
            before = least
            point, size, parameter = found
            continue
        break
    return Solution(point, size, best, least, reason, iteration)
