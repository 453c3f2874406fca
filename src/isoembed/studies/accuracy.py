"""How well the lengths are kept, and what the triangulations are like (paper, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed._embed import embed
from isoembed.aim.paper import Paper
from isoembed.gallery import SURFACES, triangulate
from isoembed.metric.curvature import corner_angles, negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.studies import plots
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.alignment import distance
from isoembed.surface.embedding import Embedding

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BODIES = ("ellipsoid", "drum")
ZERO = 1e-17  # where errors of exactly 0 are drawn
EQUATOR = 360  # directions on z = 0
LIMITS = ((30.0, 90.0), (30.0, 120.0))  # degrees: what the paper says of its triangulations, and asks for


@dataclass(frozen=True)
class _Setting:
    """A method with its tolerances, in mean edge lengths."""

    name: str
    method: Paper | str
    residual: float
    step: str


SETTINGS = (
    _Setting("paper, 1e-6", Paper(step_tolerance=1e-8), 1e-6, "1e-8"),
    _Setting("paper, 1e-9", Paper(step_tolerance=1e-11), 1e-9, "1e-11"),
    _Setting("aim, the default", "aim", 1e-10, ""),
)


def study(*, vertices: int) -> Section:
    """Embed the paper's two bodies with the paper's tolerances and with the default.

    Parameters
    ----------
    vertices : int
        Of each; the paper's pictures have 3,226 and 3,246.

    Returns
    -------
    Section
    """
    found = {name: _measured(name, vertices) for name in BODIES}
    equator = _curvature_on_equator()
    worst = {
        k: max(found[name]["settings"][k]["mean"] for name in BODIES) / setting.residual
        for k, setting in enumerate(SETTINGS)
    }
    drum = found["drum"]
    within = all(share < 1 for share in worst.values())
    angles = {name: found[name]["angles"] for name in BODIES}
    return Section(
        title="Accuracy of the lengths",
        text=(
            f"The ellipsoid and the drum with {vertices:,} vertices, from their lengths. Errors are "
            "absolute differences of lengths, measured on the vertices that are returned, in mean edge "
            "lengths. "
            "Newton's method stops below its tolerance, and its last step, which is quadratic, usually leads "
            "well below it.",
        ),
        figures=(
            Illustration(
                "length-errors",
                "Share of the edges whose error is larger than the value on the axis. Dashed: the "
                "tolerances. Errors of exactly 0 are drawn at 1e-17.",
                _error_figure(found),
            ),
        ),
        comparisons=(
            Comparison(
                "Mean difference of the lengths (section 3.1)",
                "within the tolerance, for 1e-6 and 1e-9",
                "; ".join(
                    f"{name}: " + ", ".join(f"{row['mean']:.0e}" for row in found[name]["settings"][:2])
                    for name in BODIES
                ),
                "" if within else "Beyond the tolerance: see the table.",
            ),
            Comparison(
                "Standard deviation of the differences (section 3.1)",
                "on the order of the tolerance, for 1e-6 and 1e-9",
                "; ".join(
                    f"{name}: " + ", ".join(f"{row['std']:.0e}" for row in found[name]["settings"][:2])
                    for name in BODIES
                ),
                "Smaller here: the last step is quadratic.",
            ),
            Comparison(
                "The drum has strictly positive Gaussian curvature (section 3.1)",
                "strictly positive",
                f"on z = 0 the smooth drum's K is {equator:g}; of {vertices:,} deficits "
                f"{drum['negative_deficits']} are negative",
                "K is proportional to z^2 there: the fourth power of z is flat at 0. The ellipsoid has "
                f"{found['ellipsoid']['negative_deficits']} negative deficits.",
            ),
            Comparison(
                "Angles of the triangles (section 2.2)",
                "its own triangulations: 30 to 90 degrees; enough for the convexity routine: 30 to 120",
                "; ".join(
                    f"{name}: {angles[name]['smallest']:.1f} to {angles[name]['largest']:.1f} degrees, "
                    f"{angles[name]['outside'][0]} of {angles[name]['corners']:,} outside 30 to 90, "
                    f"{angles[name]['outside'][1]} outside 30 to 120"
                    for name in BODIES
                ),
                "The triangulations are made here, by another program than the paper's.",
            ),
        ),
        tables=(
            Table(
                "Length errors, in mean edge lengths",
                ("surface", "method, tolerance", "step tolerance", "mean", "std", "largest", "vertices off"),
                tuple(
                    (
                        name,
                        setting.name,
                        setting.step,
                        *(f"{row[key]:.1e}" for key in ("mean", "std", "max", "off")),
                    )
                    for name in BODIES
                    for setting, row in zip(SETTINGS, found[name]["settings"], strict=True)
                ),
            ),
        ),
        numbers={
            "vertices": vertices,
            "curvature_on_equator": equator,
            **{
                name: {key: value for key, value in found[name].items() if key != "residuals"}
                for name in BODIES
            },
        },
    )


def _measured(name: str, n: int) -> dict[str, Any]:
    vertices, faces = triangulate(SURFACES[name](), n)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    degrees = np.degrees(corner_angles(metric))
    surfaces: list[Embedding] = [
        embed(metric, method=setting.method, tolerance=setting.residual) for setting in SETTINGS
    ]
    return {
        "settings": [
            {
                "name": setting.name,
                "mean": float(surface.residuals.mean()),
                "std": float(surface.residuals.std()),
                "max": surface.residual,
                "off": distance(surface.vertices, vertices) / metric.mean_length,
            }
            for setting, surface in zip(SETTINGS, surfaces, strict=True)
        ],
        "residuals": [surface.residuals for surface in surfaces],
        "negative_deficits": int(negative_deficits(metric).sum()),
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
    return float(np.abs(SURFACES["drum"]().gaussian_curvature(directions)).max())


def _error_figure(found: dict[str, dict[str, Any]]) -> Figure:
    figure = plots.blank(3.3)
    for axes, name in zip(figure.subplots(1, 2, sharey=True), BODIES, strict=True):
        plots.dress(axes, "error of a length", "share of the edges" if name == BODIES[0] else "", name)
        for setting, errors, color in zip(SETTINGS, found[name]["residuals"], plots.SERIES, strict=False):
            falling = np.sort(np.maximum(errors, ZERO))[::-1]
            share = np.arange(1, len(falling) + 1) / len(falling)
            axes.semilogx(falling, share, color=color, linewidth=1.6, label=setting.name)
            axes.axvline(setting.residual, color=color, linestyle="--", linewidth=1.0)
    plots.legend_below(figure, axes)
    return figure
