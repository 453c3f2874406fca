"""Still pictures of embedded horizons on a common scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from isoembed.plot.curved_space import space_name
from isoembed.plot.panel import Panel
from isoembed.plot.placed import Scale, placed_figure
from isoembed.plot.series.labels import CURVATURE, escaped
from isoembed.plot.series.placing import FIELD
from isoembed.runs.result import Result
from isoembed.space import Space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST = 50  # characters of a name in a picture


def horizon_figures(results: Sequence[Result]) -> Iterator[Figure]:
    """Draw embedded horizons as oriented in their slices, each about its center, at a common scale.

    Colors show the mean curvature, and an arrow the spin; the caption gives name, time, area and int H dA.

    Parameters
    ----------
    results : sequence of Result
        Results of embedded horizons.

    Yields
    ------
    matplotlib.figure.Figure
        One figure per result, in order.

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    panels = [
        Panel(result.arrays["vertices"], result.arrays["faces"], result.arrays[f"{FIELD}mean_curvature"])
        for result in results
    ]
    scale = Scale.of(panels) if panels else None
    for panel, result in zip(panels, results, strict=True):
        spin = result.report.get("spin") or {}
        yield placed_figure(
            panel,
            label=CURVATURE,
            caption=_caption(result.report),
            arrow=spin.get("axis"),
            name="spin",
            scale=scale,
        )


def measures_caption(report: Mapping[str, Any]) -> str:
    """Area and int H dA of a report's smooth surface, and the space if curved, one line each."""
    lines = [
        rf"area {report['area']:.8g}     $\int\! H\,dA = {report['integrated_mean_curvature']:.8g}$",
        space_name(Space(report.get("space", {}).get("curvature", 0.0))),
    ]
    return "\n".join(filter(None, lines))


def _caption(report: Mapping[str, Any]) -> str:
    """Caption of a horizon: name, time and measures."""
    name, horizon = Path(report["name"]).name, report["horizon"]
    name = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}\N{HORIZONTAL ELLIPSIS}"
    times = [f"{key} {horizon[key]:.9g}" for key in ("time", "iteration") if horizon.get(key) is not None]
    return f"{'     '.join([escaped(name), *times])}\n{measures_caption(report)}"
