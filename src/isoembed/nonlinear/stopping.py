"""Stopping rules: a residual, a short step, a small decrease, stagnation at rounding.

A rule takes a point, its value, and the smallest previous value, which is infinite at the start.
"""

from collections.abc import Callable
from typing import Any

Stop = Callable[[Any, float, float], bool]


def never(*_: Any) -> bool:
    """Never stop."""
    return False


def below(tolerance: float) -> Stop:
    """Stop when the value is at most a tolerance."""
    return lambda _, value, before: value <= tolerance


def short_step(tolerance: float) -> Stop:
    """Stop when no unknown of a `Point` changed by more than a tolerance in the last step."""
    return lambda point, value, before: point.moved <= tolerance


def settled(share: float) -> Stop:
    """Stop when a step decreased the value by at most this fraction."""
    return lambda _, value, before: not value < (1 - share) * before


def stagnated(rounding: float) -> Stop:
    """Stop when values below the rounding level cease to decrease."""
    return lambda _, value, before: before < rounding and not value < before
