"""Parsing of numbers and lengths with units and decimal commas."""

import re

MILLIMETERS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4}
"""The units of lengths on paper."""

UNIT = r"((?<![^\W\d_])(?:mm|cm|m|in|\"))?"
"""One of these or none, and not the end of another unit."""
COMMA = re.compile(r"([+-]?\d+),(\d+)")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
GROUPED = re.compile(r"([+-]?\d{1,3}(?:([ ,.'])\d{3})(?:\2\d{3})*)(?!\2)([.,]\d+)")
"""Groups of thousands before decimals, which another sign separates."""
EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")
"""Fortran's exponent of double precision."""


def ungrouped(text: str) -> str:
    """The text of a number without separators of thousands, if decimals follow, and with ``e`` for ``D``."""
    text = EXPONENT.sub("e", text.strip())
    if found := GROUPED.fullmatch(text):
        return found[1].replace(found[2], "") + found[3]
    return text


def number(text: str) -> float:
    """The number of a text, with a point or a comma before its decimals.

    Raises
    ------
    ValueError
        It is none, or the comma may as well be that of thousands, as in ``1,500``.
    """
    text = ungrouped(text)
    if (parts := COMMA.fullmatch(text)) and not THOUSANDS.fullmatch(text):
        text = f"{parts[1]}.{parts[2]}"
    return float(text)


def split_unit(text: str) -> tuple[str, str]:
    """Number and unit of a length, as texts; the unit is empty if there is none."""
    value, unit = re.fullmatch(rf"(.*?)\s*{UNIT}", text.strip(), re.DOTALL).groups()  # type: ignore[union-attr]
    return value, unit or ""


def millimeters(text: str) -> float:
    """The length of a text in millimeters, which are its unit if it has none.

    Raises
    ------
    ValueError
        It is none.
    """
    value, unit = split_unit(text)
    return number(value) * MILLIMETERS[unit or "mm"]
