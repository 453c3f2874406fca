"""HTML tables beside the horizons on a simulation's page."""

from __future__ import annotations

from html import escape

import numpy as np

from isoembed.plot.browser.report import grid, number
from isoembed.plot.series.abscissa import Abscissa
from isoembed.plot.series.placing import PlacedHorizons
from isoembed.plot.series.scenes import Scene

COLUMNS = {
    "christodoulou_mass": "<i>M</i>",
    "dimensionless_spin": "<i>χ</i>",
    "liu_yau": "<i>E</i><sub>KLY</sub>",
}


def run_report_html(placed: PlacedHorizons) -> str:
    """HTML tables of the series: a row per horizon, with the status of those not embedded."""
    along = Abscissa.of(placed.table)
    parts = []
    for name, part in placed.table.series.items():
        heads = (escape(along.column or "position"), *COLUMNS.values(), "")
        rows = [
            (
                _short(float(at) if np.isfinite(at) else None),
                *(_short(row.numbers.get(column)) for column in COLUMNS),
                "" if row.label in placed.horizons else escape(row.status),
            )
            for at, row in zip(along.of_series(part), part.rows, strict=True)
        ]
        parts.append(grid(escape(name), heads, rows))
    return "\n".join(parts)


def run_caption(placed: PlacedHorizons, first: Scene, last: Scene) -> str:
    """One line with the numbers of horizons and embedded surfaces, and the first and last time."""
    rows, names = placed.table.rows, placed.table.series
    words = [
        f"{len(names):,} horizon{'s' if len(names) > 1 else ''}: {len(placed.horizons):,} of {len(rows):,} "
        "surfaces embedded",
        f"{first.moment} to {last.moment.split()[-1]}",
    ]
    return " · ".join([*words, *filter(None, [placed.note])])


def _short(value: float | None) -> str:
    """Number with five significant digits."""
    return number(None if value is None else float(f"{value:.5g}"))
