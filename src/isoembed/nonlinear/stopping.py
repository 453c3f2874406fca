"""Stopping rules: a residual, a short step, a small decrease, stagnation at rounding.

A rule takes a point, its value, and the least value before it, which is infinite at the start.
"""

from collections.abc import Callable
from typing import Any

Stop = Callable[[Any, float, float], bool]


def never(*_: Any) -> bool:
    """No stop."""
    return False


def below(tolerance: float) -> Stop:
    """Stop where the value is at most a tolerance."""
    return lambda _, value, before: value <= tolerance


def short_step(tolerance: float) -> Stop:
    """Stop where no unknown of a `Point` moved more than a tolerance in the last step."""
    return lambda point, value, before: point.moved <= tolerance


def settled(share: float) -> Stop:
    """Stop where a step decreased the value by at most this share."""
    return lambda _, value, before: not value < (1 - share) * before


def stagnated(rounding: float) -> Stop:
    """Stop where values below rounding cease to fall."""
    return lambda _, value, before: before < rounding and not value < before
