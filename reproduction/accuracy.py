"""How well the lengths are kept, and what the triangulations are like (paper, section 3.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import Paper
from isoembed.gallery import Drum, Ellipsoid, Surface
from isoembed.metric.curvature import corner_angles, negative_deficits
from reproduction import plots
from reproduction.bodies import embedding_of, meshed
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ZERO = 1e-17  # where errors of exactly 0 are drawn
EQUATOR = 360  # directions on z = 0
LIMITS = ((30.0, 90.0), (30.0, 120.0))  # degrees: what the paper says of its triangulations, and asks for
SETTINGS: tuple[tuple[str, str | Paper, float, str], ...] = (
    ("paper, 1e-6", Paper(step_tolerance=1e-8), 1e-6, "1e-8"),
    ("paper, 1e-9", Paper(step_tolerance=1e-11), 1e-9, "1e-11"),
    ("aim, the default", "aim", 1e-10, ""),
)
"""Methods, their tolerances in mean edge lengths, and the tolerances of their steps."""


def study(*, vertices: int) -> Section:
    """The paper's two bodies with the paper's tolerances and with the default.

    Parameters
    ----------
    vertices : int
        Of each; the paper's pictures have 3,226 and 3,246.
    """
    made = ellipsoid, drum = [_measured(surface, vertices) for surface in (Ellipsoid(), Drum())]
    equator = _curvature_on_equator()
    rows = [
        {"surface": one["name"], "tolerance": tolerance, "step": step, **row}
        for one in made
        for (_, _, tolerance, step), row in zip(SETTINGS, one["settings"], strict=True)
    ]
    within = all(row["mean"] < row["tolerance"] for row in rows)
    return Section.of(
        "accuracy",
        figures={"length-errors": _error_figure(made)},
        numbers={
            "vertices": vertices,
            "curvature_on_equator": equator,
            **{
                one["name"]: {key: one[key] for key in ("settings", "negative_deficits", "angles")}
                for one in made
            },
        },
        rows=rows,
        vertices=vertices,
        made=made,
        beyond="" if within else "Beyond the tolerance: see the table.",
        equator=equator,
        drum=drum,
        ellipsoid=ellipsoid,
    )


def _measured(surface: Surface, n: int) -> dict[str, Any]:
    body = meshed(surface, n)
    degrees = np.degrees(corner_angles(body.metric))
    surfaces = [embedding_of(body, method, tolerance) for _, method, tolerance, _ in SETTINGS]
    return {
        "name": surface.name,
        "settings": [
            {
                "name": name,
                "mean": float(one.residuals.mean()),
                "std": float(one.residuals.std()),
                "max": one.residual,
                "off": one.distance(body.exact),
            }
            for (name, *_), one in zip(SETTINGS, surfaces, strict=True)
        ],
        "residuals": [one.residuals for one in surfaces],
        "negative_deficits": int(negative_deficits(body.metric).sum()),
        "angles": {
            "smallest": float(degrees.min()),
            "largest": float(degrees.max()),
            "corners": int(degrees.size),
            "outside": [int(((degrees < low) | (degrees > high)).sum()) for low, high in LIMITS],
        },
    }


def _curvature_on_equator() -> float:
    """The largest |K| of the smooth drum on z = 0."""
    phi = np.linspace(0, 2 * np.pi, EQUATOR, endpoint=False)
    directions = np.column_stack([np.cos(phi), np.sin(phi), np.zeros(EQUATOR)])
    return float(np.abs(Drum().gaussian_curvature(directions)).max())


def _error_figure(made: Sequence[Mapping[str, Any]]) -> Figure:
    figure = plots.blank(3.3)
    for axes, one in zip(figure.subplots(1, 2, sharey=True), made, strict=True):
        plots.dress(axes, "error of a length", "share of the edges" if one is made[0] else "", one["name"])
        for (label, _, tolerance, _), errors, color in zip(
            SETTINGS, one["residuals"], plots.SERIES, strict=False
        ):
            falling = np.sort(np.maximum(errors, ZERO))[::-1]
            share = np.arange(1, len(falling) + 1) / len(falling)
            axes.semilogx(falling, share, color=color, linewidth=1.6, label=label)
            axes.axvline(tolerance, color=color, linestyle="--", linewidth=1.0)
    plots.legend_below(figure, axes)
    return figure
