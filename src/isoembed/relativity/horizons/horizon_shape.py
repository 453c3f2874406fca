"""What a horizon is like within itself: its circumferences and multipoles, which need no embedding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from isoembed.relativity.horizons.circumferences import Circumferences
from isoembed.relativity.horizons.invariant_coordinate import InvariantCoordinate
from isoembed.relativity.horizons.multipoles import Multipoles
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.two_metric import is_axisymmetric


@dataclass(frozen=True)
class HorizonShape:
    """Circumferences and multipoles of a horizon, about the axis of its symmetry.

    Attributes
    ----------
    circumferences : Circumferences
    multipoles : Multipoles
    """

    circumferences: Circumferences
    multipoles: Multipoles

    @classmethod
    def of(cls, data: SurfaceData) -> HorizonShape | None:
        """The shape of a horizon; None if it has no axis.

        Parameters
        ----------
        data : SurfaceData
            Of which the metric and ``normal_momentum`` are used, and J and Q where they are given.
        """
        if not is_axisymmetric(data.metric):
            return None
        zeta = InvariantCoordinate.about_z(data.metric, data.relative_error)
        return cls(
            Circumferences.of(data.metric, zeta, data.relative_error),
            Multipoles.of(data, zeta),
        )

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: ``circumferences`` and ``multipoles``."""
        return {"circumferences": self.circumferences.report, "multipoles": self.multipoles.report}


def shape_report(data: SurfaceData) -> dict[str, Any]:
    """The report of a horizon's shape; empty of another surface."""
    shape = HorizonShape.of(data) if data.marginal else None
    return shape.report if shape else {}


def shape_lines(report: dict[str, Any]) -> list[str]:
    """The lines of a text on a report with a horizon's shape; none if it has none."""
    if "circumferences" not in report:
        return []
    found, multipoles = report["circumferences"], report["multipoles"]
    low, high = found["polar_bounds"]
    lengths = [_written(name, found[name], found["errors"][name]) for name in ("equatorial", "polar")]
    if high - low > 2.0 * found["errors"]["polar"]:
        lengths.append(f"from {low:.6g} to {high:.6g} without symmetry")
    shown = ("M", "J") if multipoles["M"] else ("I",)
    moments = [
        _written(f"{name}_{n}", multipoles[name][n], multipoles["errors"][name][n])
        for name in shown
        if multipoles[name]
        for n in ((1, 3) if name == "J" else (2, 4))
    ]
    return [f"circumferences: {', '.join(lengths)}", f"multipoles: {', '.join(moments)}"]


def _written(name: str, value: float, error: float) -> str:
    return f"{name} {value:.12g} +- {error:.0e}"
