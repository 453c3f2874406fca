"""Paper sizes and margins: named formats, custom pages and rolls."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.typed_numbers import UNIT, millimeters

FORMATS = {
    **{"A0": (841.0, 1189.0), "A1": (594.0, 841.0), "A2": (420.0, 594.0)},
    **{"A3": (297.0, 420.0), "A4": (210.0, 297.0), "A5": (148.0, 210.0)},
    **{"letter": (215.9, 279.4), "legal": (215.9, 355.6), "tabloid": (279.4, 431.8)},
}
"""Widths and heights in mm."""

MARGIN = 14.0  # mm, around the sheets; tabs extend into it
FOOT = 10.0  # mm, below them and their tabs, for the ruler and the legend
LEAST = 80.0  # mm, smallest width of a page with a ruler
NUMBER = r"(\d+(?:[.,]\d+)?)"


@dataclass(frozen=True)
class Paper:
    """A size of paper.

    Attributes
    ----------
    name : str
    width, height : float
        Size in mm.  A roll, which is cut to length, has infinite height.
    beyond : float
        Extent of seam allowances beyond that of tabs, mm.
    """

    name: str
    width: float
    height: float
    beyond: float = 0.0

    @classmethod
    def of(cls, name: str) -> Paper:
        """Paper by name: one of `FORMATS`, ``"WIDTHxHEIGHT"`` or ``"roll:WIDTH"``.

        Sizes are in mm or have a unit, as in ``"8.5x11in"``.  Names are case-insensitive.

        Raises
        ------
        InvalidParameter
            The name is unknown, or the paper is too small for a ruler.
        """
        for format_name, size in FORMATS.items():
            if str(name).lower() == format_name.lower():
                return cls(format_name, *size)
        page = re.fullmatch(f"{NUMBER}x{NUMBER}{UNIT}", str(name), re.IGNORECASE)
        roll = re.fullmatch(f"roll:{NUMBER}{UNIT}", str(name), re.IGNORECASE)
        try:
            if page:
                found = cls(
                    name, *(millimeters(f"{side}{page[3] or ''}".lower()) for side in page.groups()[:2])
                )
            elif roll:
                found = cls(name, millimeters(f"{roll[1]}{roll[2] or ''}".lower()), np.inf)
            else:
                raise ValueError
        except ValueError:
            raise InvalidParameter(
                f"paper is {name!r}, not one of {', '.join(FORMATS)}, nor WIDTHxHEIGHT or roll:WIDTH in mm"
            ) from None
        shorter = min(found.width, found.height)
        if shorter < LEAST:
            larger = (
                f"; in centimeters, write '{name}cm'"
                if str(name)[-1].isdigit() and 10 * shorter >= LEAST
                else ""
            )
            raise InvalidParameter(
                f"paper is {name!r}: less than {LEAST:g} mm has no room for margins and ruler{larger}"
            )
        return found

    @property
    def margin(self) -> float:
        """Margin around the sheets, mm."""
        return MARGIN + self.beyond

    @property
    def is_roll(self) -> bool:
        """Whether the length is unlimited."""
        return self.height == np.inf

    @property
    def turned(self) -> Paper:
        """Paper in the other orientation, portrait or landscape; a roll is unchanged."""
        return self if self.is_roll else replace(self, width=self.height, height=self.width)

    @property
    def room(self) -> Floats:
        """Width and height of the area inside the margins and above the foot, mm."""
        return np.array([self.width, self.height - FOOT]) - 2 * self.margin
