"""Abscissa of a simulation's plots: time, or iteration number if no time is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.hdf5 import enumerated
from isoembed.plot.series.labels import escaped
from isoembed.relativity.series.table import SeriesTable


@dataclass(frozen=True)
class Abscissa:
    """Abscissa: time, iteration if no time is known, or position in the series if neither is.

    Attributes
    ----------
    column : str
        Column of the table; empty for the position.
    symbol : str
        Symbol preceding a number, with an equals sign or a space.
    label : str
        Axis label; mentions the horizons without a known abscissa.
    """

    column: str
    symbol: str
    label: str

    @classmethod
    def of(cls, table: SeriesTable) -> Abscissa:
        """Abscissa for a table: time if any is known, otherwise iteration, otherwise position."""
        for column, symbol, label in (
            ("time", "t = ", "time  $t$"),
            ("iteration", "iteration ", "iteration"),
        ):
            finite = np.isfinite(table[column])
            if finite.any():
                undefined = [row.label for row, there in zip(table.rows, finite, strict=True) if not there]
                also = (
                    f"\nnot shown, of no known {column}: {escaped(enumerated(undefined))}"
                    if undefined
                    else ""
                )
                return cls(column, symbol, label + also)
        return cls("", "position ", "position in the series")

    def of_series(self, part: SeriesTable) -> Floats:
        """Abscissae of the rows of one series; NaN where unknown."""
        return part[self.column] if self.column else np.arange(len(part.rows), dtype=np.float64)

    def written(self, values: Floats) -> list[str]:
        """Ascending values with the symbol, with one digit more than needed to distinguish them."""
        steps = np.diff(values)
        step = float(np.median(steps)) if steps.size else 1.0
        places = max(0, 1 - int(np.floor(np.log10(step)))) if self.column == "time" else 0
        return [f"{self.symbol}{value:.{places}f}" for value in values.tolist()]
