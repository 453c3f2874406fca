"""Numerical thresholds with value, unit and description.

An algorithm's thresholds are the fields of one frozen dataclass, made with `threshold`; the tables of
``docs/thresholds.md`` are made from them.
"""

from collections.abc import Iterator
from dataclasses import field, fields
from typing import Any


def threshold(value: Any, unit: str, meaning: str) -> Any:
    """A field of a dataclass of thresholds.

    Parameters
    ----------
    value : number or tuple of numbers
        The default.
    unit : str
        Unit of the value, such as ``"mean edge lengths"``, ``"radians"``, ``"relative"`` or ``"count"``.
    meaning : str
        One sentence on the effect of the threshold.
    """
    return field(default=value, metadata={"unit": unit, "meaning": meaning})


def rows(thresholds: Any) -> Iterator[tuple[str, Any, str, str]]:
    """The name, value, unit and meaning of each threshold, in the order of their definition."""
    for each in fields(thresholds):
        yield each.name, getattr(thresholds, each.name), each.metadata["unit"], each.metadata["meaning"]
