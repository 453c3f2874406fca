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
"""The figures of a run by their names, with what their panels show."""
LOGARITHMIC = ("residual",)
STYLES: dict[str, Any] = {"axis_x": "-", "axis_y": (0, (5, 1.5)), "axis_z": (0, (1, 1.2))}
WIDTHS = (1.9, 0.9, 1.2)  # points, of lines of one series after the other: one is seen behind the next
WIDTH, PANEL, STRIP = 6.4, 1.55, 0.17  # inches: of a figure, the height of a panel, and of a line of outcomes


BAND = 1.0  # ranges that error bands may reach beyond the values
MARGIN = 0.06  # ranges of room above and below the lines


def series_figure(table: SeriesTable, names: Sequence[str]) -> Figure:
    """Draw numbers of a run against time, one above the other: a line for each series, with its error band.

    Where a series has no embedding, its lines are interrupted, and a mark below the panels says why.  Above
    each panel is its largest error, as bands may be thinner than lines; a band that is much wider than the
    range of the values is cut off.

    Parameters
    ----------
    table : SeriesTable
    names : sequence of str
        What the panels show: columns of the table, or ``axis`` for the three of the axis of the spin.  What
        is not known of any horizon has no panel.

    Returns
    -------
    matplotlib.figure.Figure
        With a canvas of its own: no window and no global state.

    Raises
    ------
    FileError
        matplotlib is not installed.
    InvalidParameter
        There is no such column, or none of them has a number that is known.
    """
    for name in names:
        if name not in SYMBOLS:
            raise InvalidParameter(f"there is no {name!r} to show; there are {', '.join(SYMBOLS)}")
    shown = [name for name in names if _known(table, name)]
    if not shown:
        raise InvalidParameter(f"no horizon has a value of {', '.join(names)}")
    check_drawable()
    from isoembed.plot.windowless import WindowlessFigure

    parts, along = table.series, Abscissa.of(table)
    lost = any(status != "embedded" for status in table.statuses)
    strip = STRIP * (len(parts) + 1.5) if lost else 0.0
    heights = [PANEL] * len(shown) + ([strip] if lost else [])
    picture = WindowlessFigure(WIDTH, sum(heights) + 0.9, facecolor=PAPER, layout="constrained")
    grid = picture.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    colors = colors_of(parts)
    widths = dict(zip(parts, cycle(WIDTHS), strict=False))
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
    if lost:
        draw_outcomes(
            grid[-1], {name: (along.of_series(part), part.statuses) for name, part in parts.items()}, colors
        )
    picture.align_ylabels(list(grid))
    grid[-1].set_xlabel(along.label, color=INK)
    _draw_legend(picture, colors, widths, {s for s in table.statuses if s != "embedded"}, "axis" in shown)
    return picture


def series_figures(results: Iterable[Result]) -> dict[str, Figure]:
    """Draw a run against time: the `FIGURES` of which there is anything to see, by their names.

    Parameters
    ----------
    results : iterable of Result
        In any order.

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    table = SeriesTable.of(results)
    return {
        name: series_figure(table, columns)
        for name, columns in FIGURES.items()
        if any(_known(table, column) for column in columns)
    }


def write_series_figure(path: str | os.PathLike[str], table: SeriesTable, names: Sequence[str]) -> None:
    """Write a `series_figure` as ``.png``, ``.svg`` or ``.pdf``; the same table makes the same bytes.

    Raises
    ------
    FileError
        The ending is not known, the file cannot be written, or matplotlib is not installed.
    InvalidParameter
        See `series_figure`.
    """
    check_output(path, PICTURE_ENDINGS)
    write_atomically({Path(path): figure_writer(path, series_figure(table, names))})


def _known(table: SeriesTable, name: str) -> bool:
    """Whether there is a number to show."""
    return any(bool(np.isfinite(table[column]).any()) for column in AXIS.get(name, (name,)))


@dataclass(frozen=True, eq=False)
class _Curve:
    """A number of a series against time."""

    x: Floats
    values: Floats
    errors: Floats
    column: str
    style: dict[str, Any]

    @property
    def known(self) -> Mask:
        return np.isfinite(self.values) & np.isfinite(self.x)

    @property
    def band(self) -> Floats:
        """Half the width of the band, 0 where no error is known."""
        return np.where(np.isfinite(self.errors), self.errors, 0.0)

    @property
    def isolated(self) -> Mask:
        """Mask of points without a neighbor to which a line could be drawn."""
        there = np.concatenate([[False], self.known, [False]])
        return self.known & ~there[:-2] & ~there[2:]


def _draw_panel(axes: Axes, name: str, curves: Sequence[_Curve]) -> None:
    from matplotlib.ticker import MaxNLocator

    for curve in curves:
        y = np.where(curve.known, curve.values, np.nan)
        marker = "o" if curve.known.sum() <= 60 else ""  # with more horizons, dots would cover the line
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
    errors = np.concatenate([curve.errors[curve.known] for curve in curves])
    errors = errors[np.isfinite(errors)]
    if errors.size:
        says = f"errors up to {power_of_ten(float(errors.max()))}"
        axes.set_title(says, loc="right", fontsize=7, color=INK, pad=2)


def _limits(curves: Sequence[_Curve]) -> tuple[float, float]:
    """The range of an axis: all values, and of the error bands what does not dwarf these."""
    values = np.concatenate([curve.values[curve.known] for curve in curves])
    bands = np.concatenate([curve.band[curve.known] for curve in curves])
    if not values.size:  # none of them has a time
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    typical = float(np.median(bands))
    # below a range of 1e-5 a number is constant
    span = max(high - low, 1e-5 * max(abs(low), abs(high)), 2.0 * typical) or 1.0
    lower = max(float((values - bands).min()), low - BAND * span)
    upper = min(float((values + bands).max()), high + BAND * span)
    middle, half = 0.5 * (lower + upper), 0.5 * max(upper - lower, span)
    return middle - (1 + 2 * MARGIN) * half, middle + (1 + 2 * MARGIN) * half


def _draw_legend(
    picture: Figure, colors: dict[str, str], widths: dict[str, float], lost: set[str], axis: bool
) -> None:
    """Draw which line is which, above the panels."""
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
        Line2D([], [], linestyle="", label=status, **MARKS[status]) for status in MARKS if status in lost
    ]
    picture.legend(
        handles=lines,
        loc="outside upper center",
        ncols=min(len(lines), 6),
        frameon=False,
        fontsize=8,
        labelcolor=INK,
    )
