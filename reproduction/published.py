"""Numbers of other papers beside those found here, with a second computation of another kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

NOT_AT_HAND = "not at hand"


@dataclass(frozen=True)
class Published:
    """A number of a paper beside ours.

    Attributes
    ----------
    what : str
        The quantity, with its units.
    paper : str
        The paper's number as it is printed; empty where it is not at hand.
    ours : float
    error : float
        Of ours, as stated by the package or by the convergence of the computation.
    second : float
        The same number by a computation of another kind.
    by : str
        That computation, in a few words.
    reason : str
        Why ours and the paper's differ, if they do.
    """

    what: str
    paper: str
    ours: float
    error: float
    second: float
    by: str
    reason: str = ""

    @property
    def decimals(self) -> int:
        """Decimal places that the paper prints."""
        return max(0, -int(Decimal(self.paper).as_tuple().exponent))

    @property
    def agrees(self) -> bool:
        """Whether ours, rounded to the places that the paper prints, is the paper's number."""
        return bool(self.paper) and Decimal(f"{self.ours:.{self.decimals}f}") == Decimal(self.paper)

    @property
    def row(self) -> dict[str, Any]:
        """The number as a row of text, for tables."""
        if not self.paper:
            difference, digits = "", ""
        else:
            difference = f"{self.ours - float(self.paper):+.0e}"
            digits = f"all {len(Decimal(self.paper).as_tuple().digits)}" if self.agrees else "not all"
        return {
            "what": self.what,
            "paper": self.paper or NOT_AT_HAND,
            "ours": self.shown,
            "digits": digits,
            "difference": difference,
            "second": f"{self.second:.{self._places}f}",
            "apart": f"{self.ours - self.second:+.0e}",
            "by": self.by,
            "reason": self.reason or ("rounding of the printed number" if self.agrees else ""),
        }

    @property
    def shown(self) -> str:
        """Ours to the places that its error leaves."""
        return f"{self.ours:.{self._places}f}"

    @property
    def _places(self) -> int:
        return min(12, max(0, -Decimal(f"{max(self.error, 1e-12):.0e}").adjusted()))

    @property
    def numbers(self) -> dict[str, Any]:
        """The number for ``numbers.json``."""
        return {**vars(self), "paper": self.paper or None, "agrees": self.agrees if self.paper else None}


def rows(numbers: Sequence[Published]) -> list[dict[str, Any]]:
    """The rows of a table."""
    return [number.row for number in numbers]
