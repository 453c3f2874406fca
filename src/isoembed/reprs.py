"""Texts of results: short `repr`, HTML tables in notebooks, lists, counts, bounds rounded up or down."""

from __future__ import annotations

import numbers
from collections.abc import Iterator, Sequence
from dataclasses import fields
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import Any, TypeVar

import numpy as np

Kind = TypeVar("Kind", bound=type)

SMALL = 4  # numbers that are shown one by one
LONGEST = 60  # characters of a text
MOST = 8  # entries of a repr; a table has all


def listed(items: Sequence[str], most: int = 5) -> str:
    """Text with the first items and the number of the others."""
    more = len(items) - most
    return ", ".join(items[:most]) + (f" and {more} more" if more > 0 else "")


def counted(number: int, noun: str) -> str:
    """Number of things, with the noun in the plural unless it is one."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def rounded_up(value: float, digits: int = 2) -> str:
    """Text of a positive number rounded up to some significant digits, so that a user can pass it back."""
    return f"{float(Context(digits, ROUND_CEILING).create_decimal(value)):.{digits - 1}e}"


def rounded_down(value: float, digits: int = 2) -> str:
    """Text of a positive number rounded down to some significant digits."""
    return f"{float(Context(digits, ROUND_FLOOR).create_decimal(value)):.{digits - 1}e}"


def short_repr(cls: Kind) -> Kind:
    """Give a dataclass a repr of one line and a table for notebooks.

    These show its fields, or the pairs of a name and a value from its method ``_shown``, except those that
    are None, empty or functions; of large arrays the shape.
    """
    cls.__repr__ = _repr  # type: ignore[assignment,misc,method-assign,unused-ignore]
    if "_repr_html_" not in vars(cls):
        cls._repr_html_ = html_table  # type: ignore[attr-defined]
    return cls


def _repr(self: Any) -> str:
    entries = [f"{name}={value}" for name, value in _entries(self)]
    more = ["..."] if len(entries) > MOST else []
    return f"{type(self).__name__}({', '.join([*entries[:MOST], *more])})"


def html_table(self: Any) -> str:
    """Table for a dataclass in a notebook."""
    from html import escape  # slow to import, and seldom needed

    rows = "".join(
        f'<tr><th scope="row" style="text-align: left">{escape(name.replace("_", " "))}</th>'
        f'<td style="text-align: left">{escape(value)}</td></tr>'
        for name, value in _entries(self)
    )
    return f"<table><caption>{escape(type(self).__name__)}</caption><tbody>{rows}</tbody></table>"


def _entries(self: Any) -> Iterator[tuple[str, str]]:
    own = getattr(self, "_shown", None)
    found = own() if own else ((field.name, getattr(self, field.name)) for field in fields(self))
    for name, value in found:
        text = _text(value)
        if text:
            yield name, text


def _text(value: Any) -> str:
    """A value in a few characters; none if there is nothing to show."""
    if value is None or callable(value) or (isinstance(value, str | tuple | list) and not value):
        return ""
    if isinstance(value, bool | np.bool_ | numbers.Integral):
        return str(value)
    if isinstance(value, numbers.Real):
        return f"{float(value):.6g}"
    if isinstance(value, str):
        return repr(value) if len(value) <= LONGEST else f"{value[: LONGEST - 3]!r}..."
    if isinstance(value, np.ndarray):
        if value.ndim == 1 and value.size <= SMALL:
            return f"[{', '.join(_text(each) for each in value.tolist())}]"
        return f"array of shape {value.shape}"
    if isinstance(value, tuple | list):
        if len(value) <= SMALL and all(isinstance(each, numbers.Real) for each in value):
            return f"({', '.join(map(_text, value))})"
        return f"{len(value)} entries"
    if type(value).__str__ is not object.__str__:  # an Estimate
        return str(value)
    text = repr(value)
    return text if len(text) <= LONGEST else f"{type(value).__name__}(...)"
