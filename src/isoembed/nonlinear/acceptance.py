"""Acceptance rules: sufficient decrease with a backtracking line search, and Levenberg-Marquardt damping.

A rule tries parameters of a curve in turn, accepts the first with a sufficiently small value (never NaN), and
determines the initial parameter of the next step.

References
----------
P. Deuflhard, Newton Methods for Nonlinear Problems (2004), sections 2.1 and 3.1.
J. Nocedal and S. J. Wright, Numerical Optimization, 2nd ed. (2006), sections 3.1 and 10.3.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, takewhile

import numpy as np


@dataclass(frozen=True)
class LineSearch:
    """Backtracking line search: fractions 1, 1/2, 1/4, ... of a step until the value decreases sufficiently.

    Attributes
    ----------
    decrease : float
        Constant c in ``value < (1 - c * fraction) * before``; 0 for any decrease.
    shortest : float
        Smallest fraction tried.
    """

    decrease: float
    shortest: float
    first = 1.0

    def parameters(self, first: float = 1.0) -> Iterator[float]:
        """Fractions, starting with the first and halved successively."""
        return takewhile(lambda fraction: fraction >= self.shortest, _powers(first, 0.5))

    def accepts(self, value: float, before: float, fraction: float) -> bool:
        """Whether the decrease is sufficient."""
        return value < (1 - self.decrease * fraction) * before

    def following(self, value: float, before: float, fraction: float) -> float:
        """Initial fraction of the next step: a full step."""
        return 1.0


FULL_STEPS = LineSearch(-np.inf, 1.0)
"""Full steps, accepted without a test."""


def contraction(share: float) -> LineSearch:
    """Full steps that each reduce the value to less than a fraction `share`."""
    return LineSearch(1 - share, 1.0)


@dataclass(frozen=True)
class Damping:
    """Levenberg-Marquardt damping: raised until the value decreases, and lowered after a decrease.

    Attributes
    ----------
    first : float
    stiffer, softer : float
        Factors after an increase, and after a decrease.
    largest : float
        Largest damping tried.
    tries : int
        Maximum number of dampings per step.
    eased_below : float
        Ratio of values below which the damping is lowered.
    """

    first: float
    stiffer: float = 5.0
    softer: float = 0.2
    largest: float = np.inf
    tries: int = 100
    eased_below: float = 1.0

    def parameters(self, first: float) -> Iterator[float]:
        """Dampings in increasing order."""
        return islice(takewhile(lambda mu: mu <= self.largest, _powers(first, self.stiffer)), self.tries)

    def accepts(self, value: float, before: float, damping: float) -> bool:
        """Whether there is any decrease."""
        return value < before

    def following(self, value: float, before: float, damping: float) -> float:
        """Damping for the next step, softer after a sufficient decrease."""
        return damping * self.softer if value < self.eased_below * before else damping


def _powers(first: float, factor: float) -> Iterator[float]:
    while True:
        yield first
        first *= factor
