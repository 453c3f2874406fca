"""Strip chart of success and failure for every horizon of a simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.plot.picture import INK
from isoembed.plot.series.labels import escaped
from isoembed.runs.result import FAILED, REFUSED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WRONG = "#c8102e"
MARKS: dict[str, dict[str, Any]] = {
    "not embedded": {"marker": "x", "color": WRONG, "markersize": 5},
    "best fit": {"marker": "d", "color": WRONG, "markersize": 4},
    REFUSED: {"marker": "s", "color": WRONG, "markersize": 4, "markerfacecolor": "none"},
    FAILED: {"marker": "v", "color": WRONG, "markersize": 5},
}
"""Marker styles of horizons without embedding, by status."""


def draw_outcomes(
    axes: Axes, series: Mapping[str, tuple[Floats, Sequence[str]]], colors: Mapping[str, str]
) -> None:
    """Draw a row per series: a tick for each embedded horizon, and the `MARKS` of the others.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    series : mapping of str to (ndarray, sequence of str)
        Positions of the horizons along the axis, and their statuses.
    colors : mapping of str to str
        Colors of the series.
    """
    for row, (name, (x, statuses)) in enumerate(series.items()):
        for status in dict.fromkeys(statuses):
            here = x[np.array([s == status for s in statuses])]
            style = MARKS.get(status, {"marker": "|", "color": colors[name], "markersize": 4})
            axes.plot(here, np.full(len(here), -row), linestyle="", clip_on=False, **style)
    axes.set_ylim(-len(series) + 0.4, 0.6)
    axes.set_yticks(-np.arange(len(series)), [escaped(name) for name in series])
    axes.tick_params(colors=INK, labelsize=8, direction="in", left=False)
