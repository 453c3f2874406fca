"""Acceptance rules: sufficient decrease with a backtracking line search, and Levenberg-Marquardt damping.

A rule tries parameters of a curve in turn and accepts the first whose value is small enough.  A value that is
not a number is never accepted.

References
----------
P. Deuflhard, Newton Methods for Nonlinear Problems (2004), sections 2.1 and 3.1.
J. Nocedal and S. J. Wright, Numerical Optimization, 2nd ed. (2006), sections 3.1 and 10.3.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Acceptance(Protocol):
    """A rule for the parameter of a step's curve."""

    @property
    def first(self) -> float:
        """Parameter with which the first step begins."""

    def parameters(self, first: float) -> Iterator[float]:
        """Parameters in the order in which they are tried."""

    def accepts(self, value: float, before: float, parameter: float) -> bool:
        """Whether a value is small enough after one before."""

    def following(self, value: float, before: float, parameter: float) -> float:
        """Parameter with which the next step begins, after an accepted one."""


@dataclass(frozen=True)
class LineSearch:
    """Backtracking line search: fractions 1, 1/2, 1/4, ... of a step until the value decreases sufficiently.

    Attributes
    ----------
    decrease : float
        c in ``value < (1 - c * fraction) * before``: a share of the decrease of the linear model; 0 for any
        decrease.
    shortest : float
        Least fraction that is tried.
    """

    decrease: float
    shortest: float
    first = 1.0

    def parameters(self, first: float = 1.0) -> Iterator[float]:
        """Fractions from the first on, each half of the one before."""
        fraction = first
        while fraction >= self.shortest:
            yield fraction
            fraction /= 2

    def accepts(self, value: float, before: float, parameter: float) -> bool:
        """Sufficient decrease."""
        return value < (1 - self.decrease * parameter) * before

    def following(self, value: float, before: float, parameter: float) -> float:
        """A whole step."""
        return 1.0


FULL_STEPS = LineSearch(-np.inf, 1.0)
"""Whole steps, wherever they lead."""


def contraction(share: float) -> LineSearch:
    """Whole steps while each leaves less than this share of the value: the test of quadratic convergence."""
    return LineSearch(1 - share, 1.0)


@dataclass(frozen=True)
class Damping:
    """Levenberg-Marquardt damping: raised until the value decreases, and lowered after a decrease.

    Attributes
    ----------
    first : float
    stiffer, softer : float
        Factors after a step uphill, and after one downhill.
    largest : float
        No step helps with more.
    tries : int
        Dampings that are tried for one step.
    eased_below : float
        Share of the value that a step leaves at most before the damping is lowered.
    """

    first: float
    stiffer: float = 5.0
    softer: float = 0.2
    largest: float = np.inf
    tries: int = 100
    eased_below: float = 1.0

    def parameters(self, first: float) -> Iterator[float]:
        """Dampings, each stiffer than the one before."""
        damping = first
        for _ in range(self.tries):
            if damping > self.largest:
                return
            yield damping
            damping *= self.stiffer

    def accepts(self, value: float, before: float, parameter: float) -> bool:
        """Any decrease."""
        return value < before

    def following(self, value: float, before: float, parameter: float) -> float:
        """A softer damping after a decrease."""
        return parameter * self.softer if value < self.eased_below * before else parameter
