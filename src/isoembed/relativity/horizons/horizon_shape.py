"""Intrinsic shape of a horizon: circumferences and multipoles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.relativity.horizons.approximate_killing import rotations
from isoembed.relativity.horizons.circumferences import Circumferences
from isoembed.relativity.horizons.invariant_coordinate import InvariantCoordinate
from isoembed.relativity.horizons.multipoles import Multipoles
from isoembed.relativity.horizons.spin import Spin
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.reprs import short_repr
from isoembed.smooth.transforms import resized
from isoembed.smooth.uncertain import Uncertainty
from isoembed.surface.estimate import Estimate


@short_repr
@dataclass(frozen=True)
class HorizonShape:
    """Circumferences and multipoles of a horizon about its (approximate) symmetry axis.

    Attributes
    ----------
    circumferences : Circumferences
    multipoles : Multipoles
    axis : three floats
        Unit vector of the mean gradient of zeta, on the sphere of directions of the metric.
    """

    circumferences: Circumferences
    multipoles: Multipoles
    axis: tuple[float, float, float]

    @classmethod
    def of(cls, data: SurfaceData, spin: Spin | None = None) -> HorizonShape:
        """Shape of a horizon.

        Parameters
        ----------
        data : SurfaceData
            Surface; its metric, ``normal_momentum``, and J and Q if given, are used.
        spin : Spin, optional
            Spin of the surface, from `find_spin`; without it, the poles are those of the rotation of least
            shear.

        Raises
        ------
        InvalidMetric
            The metric is not positive definite.
        """
        zeta, error, moved = _coordinate(data, spin), data.lengths_error, data.displacement
        lengths = Uncertainty(error.pointwise + moved, error.mean + moved)
        x, y, z = zeta.axis.tolist()
        return cls(Circumferences.of(data.metric, zeta, lengths), Multipoles.of(data, zeta), (x, y, z))

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: ``circumferences``, ``multipoles`` and their ``shape_axis``."""
        return {
            "circumferences": self.circumferences.report,
            "multipoles": self.multipoles.report,
            "shape_axis": list(self.axis),
        }


def _coordinate(data: SurfaceData, spin: Spin | None) -> InvariantCoordinate:
    """Invariant coordinate of the symmetry about the spin or z, or of the most nearly Killing rotation."""
    metric, error = data.metric, data.relative_error
    turning = None if spin is None else spin.zeta
    upright = InvariantCoordinate.about(metric, relative_error=error)
    if turning is None:
        return upright or _of_least_shear(data)
    # The axis of the spin is the z-axis within errors.
    if upright is not None and abs(turning.axis[2]) > 0.9:
        return upright
    return InvariantCoordinate.about(metric, turning.axis.tolist(), error) or turning


def _of_least_shear(data: SurfaceData) -> InvariantCoordinate:
    """Invariant coordinate of the rotation of least shear; the largest component of its axis is positive."""
    few = rotations(data.metric, 8, False)
    for degree in (12, 16):
        more = rotations(data.metric, degree, False)
        before, potential = (three.coefficients @ three.weights_of_least_shear for three in (few, more))
        before = resized(before[:, None], few.harmonics, more.harmonics)[:, 0]
        change = min(float(np.linalg.norm(potential - sign * before)) for sign in (1.0, -1.0))
        if change <= 1e-6:  # relative change of the potential between degrees
            break
        few = more
    zeta = InvariantCoordinate.of_potential(potential, more.harmonics, change + data.relative_error)
    return zeta if zeta.axis[np.argmax(np.abs(zeta.axis))] > 0.0 else zeta.reversed()


def shape_lines(report: dict[str, Any]) -> list[str]:
    """Lines of text for a report with the shape of a horizon; none if it has no shape."""
    if "circumferences" not in report:
        return []
    found, multipoles = report["circumferences"], report["multipoles"]
    low, high = found["polar_bounds"]
    lengths = [_written(name, found[name], found["errors"][name]) for name in ("equatorial", "polar")]
    if high - low > 4.0 * found["errors"]["polar"]:  # the bounds include the error
        lengths.append(f"from {low:.8g} to {high:.8g} without symmetry")
    shown = ("M", "J") if multipoles["M"] else ("I",)
    moments = [
        _written(f"{name}_{n}", multipoles[name][n], multipoles["errors"][name][n])
        for name in shown
        if multipoles[name]
        for n in ((1, 3) if name == "J" else (2, 4))
    ]
    about = ""
    if axis := report.get("shape_axis"):  # results of older versions have none
        about = " about ({})".format(", ".join(f"{x + 0.0:.3g}" for x in np.round(axis, 4)))
    return [f"circumferences{about}: {', '.join(lengths)}", f"multipoles: {', '.join(moments)}"]


def _written(name: str, value: float, error: float) -> str:
    return f"{name} {Estimate(value, error)}"
