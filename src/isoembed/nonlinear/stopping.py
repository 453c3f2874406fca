"""Stopping rules: residual, relative decrease, stagnation at rounding.

A rule takes a point, its value, and the least value before it, infinite at the start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Stop = Callable[[Any, float, float], bool]


def never(point: Any, value: float = 0.0, before: float = 0.0) -> bool:
    """No stop."""
    return False


def below(tolerance: float) -> Stop:
    """Stop when the value is at most a tolerance."""
    return lambda point, value, before: value <= tolerance


def short_step(tolerance: float) -> Stop:
    """Stop when no unknown of a `Point` moved more than a tolerance in the last step."""
    return lambda point, value, before: point.moved <= tolerance


def settled(share: float) -> Stop:
    """Stop when a step decreases the value by at most this share of it."""
    return lambda point, value, before: not value < (1 - share) * before


def stagnated(rounding: float) -> Stop:
    """Stop when values below rounding cease to fall."""
    return lambda point, value, before: before < rounding and not value < before
