"""Acceptance rules: sufficient decrease with a backtracking line search, and Levenberg-Marquardt damping.

A rule tries parameters of a curve in turn, and accepts the first whose value is small enough: never one that
is not a number.  It says with which parameter the next step begins.

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
        c in ``value < (1 - c * fraction) * before``; 0 for any decrease.
    shortest : float
        Least fraction that is tried.
    """

    decrease: float
    shortest: float
    first = 1.0

    def parameters(self, first: float = 1.0) -> Iterator[float]:
        """Fractions from the first on, each half of the one before."""
        return takewhile(lambda fraction: fraction >= self.shortest, _powers(first, 0.5))

    def accepts(self, value: float, before: float, fraction: float) -> bool:
        """Whether the decrease is sufficient."""
        return value < (1 - self.decrease * fraction) * before

    def following(self, value: float, before: float, fraction: float) -> float:
        """A whole step."""
        return 1.0


FULL_STEPS = LineSearch(-np.inf, 1.0)
"""Full steps, accepted without a test."""


def contraction(share: float) -> LineSearch:
    """Full steps, each of which must reduce the value to less than `share` of itself."""
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
        Most dampings for one step.
    eased_below : float
        Share of the value below which a step must lead for the damping to be lowered.
    """

    first: float
    stiffer: float = 5.0
    softer: float = 0.2
    largest: float = np.inf
    tries: int = 100
    eased_below: float = 1.0

    def parameters(self, first: float) -> Iterator[float]:
        """Dampings, each stiffer than the one before."""
        return islice(takewhile(lambda mu: mu <= self.largest, _powers(first, self.stiffer)), self.tries)

    def accepts(self, value: float, before: float, damping: float) -> bool:
        """Whether there is any decrease."""
        return value < before

    def following(self, value: float, before: float, damping: float) -> float:
        """A softer damping after a decrease."""
        return damping * self.softer if value < self.eased_below * before else damping


def _powers(first: float, factor: float) -> Iterator[float]:
    while True:
        yield first
        first *= factor
