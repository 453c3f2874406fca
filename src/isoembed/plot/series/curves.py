"""Time series plots with error bands."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidParameter
from isoembed.io.files import write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.endings import PICTURE_ENDINGS
from isoembed.plot.picture import INK, PAPER, check_drawable, figure_writer
from isoembed.plot.series.abscissa import Abscissa
from isoembed.plot.series.labels import AXIS, SYMBOLS, colors_of, escaped, power_of_ten
from isoembed.plot.series.outcomes import MARKS, draw_outcomes
from isoembed.relativity.series.table import ERRORS, SeriesTable
from isoembed.runs.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = {
    "masses": ("irreducible_mass", "christodoulou_mass", "area"),
    "spin": ("J", "dimensionless_spin", "axis"),
    "energies": ("integrated_mean_curvature", "hawking", "brown_york", "liu_yau", "wang_yau"),
    "embedding": ("residual", "degree"),
}
"""Figures of a run by name, with the columns shown in their panels."""
LOGARITHMIC = ("residual",)
STYLES: dict[str, Any] = {"axis_x": "-", "axis_y": (0, (5, 1.5)), "axis_z": (0, (1, 1.2))}
BAND = 1.0  # largest extent of error bands beyond the values, relative to their range
MARGIN = 0.06  # space above and below the lines, relative to the range


def series_figure(table: SeriesTable, names: Sequence[str]) -> Figure:
    """Plot quantities of a run against time, in stacked panels: one line per series, with an error band.

    Lines are interrupted where a series has no embedding, and a mark below the panels gives the outcome.  The
    largest error is written above each panel, as bands may be thinner than lines; bands much wider than the
    range of the values are clipped.

    Parameters
    ----------
    table : SeriesTable
    names : sequence of str
        Quantities of the panels: columns of the table, or ``axis`` for the three components of the spin axis.
        Quantities unknown for all horizons are omitted.

    Returns
    -------
    matplotlib.figure.Figure
        Figure with its own canvas: no window and no global state.

    Raises
    ------
    FileError
        matplotlib is not installed.
    InvalidParameter
        A column does not exist, or none has a known value.
    """
    for name in names:
        if name not in SYMBOLS:
            raise InvalidParameter(f"there is no quantity {name!r}; there are {', '.join(SYMBOLS)}")
    shown = [name for name in names if _has_values(table, name)]
    if not shown:
        raise InvalidParameter(f"no horizon has a value of {', '.join(names)}")
    check_drawable()
    from isoembed.plot.windowless import WindowlessFigure

    parts, along = table.series, Abscissa.of(table)
    has_failures = any(status != "embedded" for status in table.statuses)
    # Inches: 1.55 for a panel, 0.17 for a row of outcomes.
    heights = [1.55] * len(shown) + ([0.17 * (len(parts) + 1.5)] if has_failures else [])
    picture = WindowlessFigure(6.4, sum(heights) + 0.9, facecolor=PAPER, layout="constrained")
    grid = picture.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    colors = colors_of(parts)
    widths = dict(zip(parts, cycle((1.9, 0.9, 1.2)), strict=False))  # hidden lines stay visible
    for name, axes in zip(shown, grid, strict=False):
        curves = [
            _Curve(
                along.of_series(part),
                part[column],
                part[ERRORS.get(column, "")],
                column,
                {
                    "color": colors[series],
                    "linewidth": widths[series],
                    "markersize": 1.2 + 1.3 * widths[series],
                },
            )
            for series, part in parts.items()
            for column in AXIS.get(name, (name,))
        ]
        _draw_panel(axes, name, curves)
    if has_failures:
        draw_outcomes(
            grid[-1], {name: (along.of_series(part), part.statuses) for name, part in parts.items()}, colors
        )
    picture.align_ylabels(list(grid))
    grid[-1].set_xlabel(along.label, color=INK)
    _draw_legend(picture, colors, widths, {s for s in table.statuses if s != "embedded"}, "axis" in shown)
    return picture


def series_figures(results: Iterable[Result]) -> dict[str, Figure]:
    """Plot a run against time: all `FIGURES` with known values, by name.

    Parameters
    ----------
    results : iterable of Result
        Results in any order.

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    table = SeriesTable.of(results)
    return {
        name: series_figure(table, columns)
        for name, columns in FIGURES.items()
        if any(_has_values(table, column) for column in columns)
    }


def write_series_figure(path: str | os.PathLike[str], table: SeriesTable, names: Sequence[str]) -> None:
    """Write a `series_figure` as ``.png``, ``.svg`` or ``.pdf``; equal tables yield identical files.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib is not installed.
    InvalidParameter
        See `series_figure`.
    """
    check_output(path, PICTURE_ENDINGS)
    write_atomically({Path(path): figure_writer(path, series_figure(table, names))})


def _has_values(table: SeriesTable, name: str) -> bool:
    """Whether a quantity has any known value."""
    return any(bool(np.isfinite(table[column]).any()) for column in AXIS.get(name, (name,)))


@dataclass(frozen=True, eq=False)
class _Curve:
    """A quantity of a series against time."""

    x: Floats
    values: Floats
    errors: Floats
    column: str
    style: dict[str, Any]

    @property
    def finite(self) -> Mask:
        return np.isfinite(self.values) & np.isfinite(self.x)

    @property
    def band(self) -> Floats:
        """Half width of the error band, 0 if no error is known."""
        return np.where(np.isfinite(self.errors), self.errors, 0.0)

    @property
    def isolated(self) -> Mask:
        """Mask of points without neighbors on the curve."""
        there = np.concatenate([[False], self.finite, [False]])
        return self.finite & ~there[:-2] & ~there[2:]


def _draw_panel(axes: Axes, name: str, curves: Sequence[_Curve]) -> None:
    from matplotlib.ticker import MaxNLocator

    for curve in curves:
        y = np.where(curve.finite, curve.values, np.nan)
        marker = "o" if curve.finite.sum() <= 60 else ""  # more markers would cover the line
        axes.plot(curve.x, y, linestyle=STYLES.get(curve.column, "-"), marker=marker, **curve.style)
        if curve.column in ERRORS:
            edges = y - curve.band, y + curve.band
            axes.fill_between(curve.x, *edges, color=curve.style["color"], alpha=0.28, linewidth=0.0)
            one = curve.isolated
            axes.errorbar(curve.x[one], y[one], curve.band[one], fmt="o", capsize=2, **curve.style)
    if name in LOGARITHMIC:
        axes.set_yscale("log")
    else:
        axes.set_ylim(*_limits(curves))
        axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-4, 5))
        axes.yaxis.get_offset_text().set_fontsize(7)
        axes.yaxis.set_major_locator(MaxNLocator(5, integer=name == "degree"))
    axes.set_ylabel(SYMBOLS[name], color=INK, fontsize=9)
    axes.tick_params(colors=INK, labelsize=8, direction="in", top=True, right=True)
    axes.grid(alpha=0.25, linewidth=0.5)
    errors = np.concatenate([curve.errors[curve.finite] for curve in curves])
    errors = errors[np.isfinite(errors)]
    if errors.size:
        says = f"errors up to {power_of_ten(float(errors.max()))}"
        axes.set_title(says, loc="right", fontsize=7, color=INK, pad=2)


def _limits(curves: Sequence[_Curve]) -> tuple[float, float]:
    """Axis limits: all values, and error bands as far as these do not dwarf the values."""
    values = np.concatenate([curve.values[curve.finite] for curve in curves])
    bands = np.concatenate([curve.band[curve.finite] for curve in curves])
    if not values.size:  # no time is known
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    typical = float(np.median(bands))
    # Variations below 1e-5 are shown as constant.
    span = max(high - low, 1e-5 * max(abs(low), abs(high)), 2.0 * typical) or 1.0
    lower = max(float((values - bands).min()), low - BAND * span)
    upper = min(float((values + bands).max()), high + BAND * span)
    middle, half = 0.5 * (lower + upper), 0.5 * max(upper - lower, span)
    return middle - (1 + 2 * MARGIN) * half, middle + (1 + 2 * MARGIN) * half


def _draw_legend(
    picture: Figure, colors: dict[str, str], widths: dict[str, float], failed: set[str], axis: bool
) -> None:
    """Draw the legend above the panels."""
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=color, linewidth=widths[name], label=escaped(name))
        for name, color in colors.items()
    ]
    if axis:
        lines += [
            Line2D([], [], color=INK, linestyle=style, label=f"axis ${column[-1]}$")
            for column, style in STYLES.items()
        ]
    lines += [
        Line2D([], [], linestyle="", label=status, **MARKS[status]) for status in MARKS if status in failed
    ]
    picture.legend(
        handles=lines,
        loc="outside upper center",
        ncols=min(len(lines), 6),
        frameon=False,
        fontsize=8,
        labelcolor=INK,
    )
