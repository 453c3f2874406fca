"""Still pictures of embedded horizons on a common scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from isoembed.plot.drawn import said
from isoembed.plot.panel import Panel
from isoembed.plot.placed import Scale, placed_figure
from isoembed.plot.series.labels import CURVATURE, escaped
from isoembed.plot.series.placing import FIELD
from isoembed.runs.result import Result
from isoembed.space import Space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST = 50  # letters of a name in a picture


def horizon_figures(results: Sequence[Result]) -> Iterator[Figure]:
    """Draw embedded horizons as they lie in their slices, each about its center, in one scale.

    Colors show the mean curvature, an arrow the spin; below are name, time, area and int H dA.

    Parameters
    ----------
    results : sequence of Result
        Of horizons that are embedded.

    Yields
    ------
    matplotlib.figure.Figure
        One for each, in their order.

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
    """Area and int H dA of the smooth surface of a report, and the space if that is curved: a line each."""
    lines = [
        rf"area {report['area']:.8g}     $\int\! H\,dA = {report['integrated_mean_curvature']:.8g}$",
        said(Space(report.get("space", {}).get("curvature", 0.0))),
    ]
    return "\n".join(filter(None, lines))


def _caption(report: Mapping[str, Any]) -> str:
    """The name and the time above what is known of a horizon."""
    name, horizon = Path(report["name"]).name, report["horizon"]
    name = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}\N{HORIZONTAL ELLIPSIS}"
    times = [f"{key} {horizon[key]:.9g}" for key in ("time", "iteration") if horizon.get(key) is not None]
    return f"{'     '.join([escaped(name), *times])}\n{measures_caption(report)}"
