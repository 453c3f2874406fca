"""Parsing of numbers and lengths with units and decimal commas."""

import re

MILLIMETERS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4}
"""The units of lengths on paper."""

UNIT = r"(mm|cm|m|in|\")?"
COMMA = re.compile(r"([+-]?\d+),(\d+)")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")


def number(text: str) -> float:
    """The number of a text, with a point or a comma before its decimals.

    Raises
    ------
    ValueError
        It is none, or the comma may as well be that of thousands, as in ``1,500``.
    """
    if (parts := COMMA.fullmatch(text.strip())) and not THOUSANDS.fullmatch(text.strip()):
        text = f"{parts[1]}.{parts[2]}"
    return float(text)


def millimeters(text: str) -> float:
    """The length of a text in millimeters, which are its unit if it has none.

    Raises
    ------
    ValueError
        It is none.
    """
    value, unit = re.fullmatch(rf"(.*?)\s*{UNIT}", text.strip(), re.DOTALL).groups()  # type: ignore[union-attr]
    return number(value) * MILLIMETERS[unit or "mm"]
