"""Classification of surfaces as horizons by the expansion of outgoing light rays."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of, momentum_of, values_of
from isoembed.reprs import short_repr
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import area_density
from isoembed.surface.estimate import percent

ROUNDING = 1e-12  # rounding error of the expansion, relative to the largest k
CLOSE = 0.01  # largest relative displacement: a tenth of the Kijowski-Liu-Yau energy


@short_repr
@dataclass(frozen=True)
class ExpansionTest:
    """Test whether a surface is a horizon, by the expansion of outgoing light rays.

    Attributes
    ----------
    largest_expansion : float
        Maximum of ``|theta_+| = |k - p|``; 0 on a horizon.
    expansion_error : float
    displacement : float
        Estimated displacement of the horizon from the surface, relative to its radius: the part of
        ``(k^2 - p^2) A / 16 pi`` in harmonics of degree 0, 1 and 2.  In any slice of Schwarzschild spacetime
        this is 1 - 2 M / R for a sphere of areal radius R.
    displacement_error : float
    inward : bool
        Whether k + p nearly vanishes and k - p does not: K_ij may have the opposite sign.
    """

    largest_expansion: float
    expansion_error: float
    displacement: float
    displacement_error: float
    inward: bool

    @property
    def is_zero(self) -> bool:
        """Whether the expansion vanishes within its error, and the error is small."""
        return (
            not self.inward
            and self.largest_expansion <= 2.0 * self.expansion_error
            and self.displacement <= self.displacement_error <= CLOSE
        )

    @property
    def is_small(self) -> bool:
        """Whether the horizon is near enough, within errors, to treat the surface as a horizon."""
        return not self.inward and self.displacement <= max(CLOSE, self.displacement_error)

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return asdict(self)


def expansion_test(data: SurfaceData) -> ExpansionTest:
    """Test whether a surface is a horizon of its slice.

    Parameters
    ----------
    data : SurfaceData
        Surface with its mean curvature.

    Raises
    ------
    InvalidParameter
        There is no mean curvature, or a function returns an array of wrong shape.
    """
    if data.mean_curvature is None:
        raise InvalidParameter("a horizon cannot be identified without the mean curvature")
    u, weights = gauss_rule(48, 96)
    k = values_of(data.mean_curvature, u, "the mean curvature")
    p = momentum_of(data, u)
    if isinstance(data.metric, GridMetric):
        p = np.abs(p)  # the sign convention of a file is unknown
    dA = weights * area_density(data.metric.tensor(u))
    mean = float(dA.sum()) / (4.0 * np.pi)
    smooth = (
        # Displacement from harmonics of k^2 - p^2 up to degree 2.
        Harmonics(2, 2).values(u) * (dA / np.sqrt(4.0 * np.pi))[:, None]
    )
    errors = error_of(data.mean_curvature), error_of(data.momentum)
    sizes = float(np.abs(k).max()), float(np.abs(p).max())
    lengths = 2.0 * data.lengths_error.mean * sum(sizes)
    lengths += ROUNDING * (sum(sizes) + 1.0 / float(np.sqrt(mean)))
    pointwise, average = (
        lengths + sum(getattr(error, name) for error in errors) for name in ("pointwise", "mean")
    )
    # (k^2 - p^2) A / 16 pi, where A / 16 pi = mean / 4
    displaced = 0.25 * float(np.linalg.norm((k**2 - p**2) @ smooth))
    return ExpansionTest(
        largest_expansion=float(np.abs(k - p).max()),
        expansion_error=pointwise,
        displacement=displaced,
        displacement_error=ROUNDING
        # Errors of k and p partly cancel in the displacement (measured factor: 0.27).
        + 0.4 * 0.25 * mean * max(sum(sizes), average) * average,
        inward=bool(np.abs(k + p).max() < 0.1 * np.abs(k - p).max()),  # k + p vanishes instead of k - p
    )


def classify_horizon(
    data: SurfaceData, marginal: bool | None, test: ExpansionTest | None = None
) -> SurfaceData:
    """Classify a surface as a horizon or not, and return its data with matching errors and notes.

    Parameters
    ----------
    data : SurfaceData
    marginal : bool, optional
        Whether it is a horizon; by default `expansion_test` decides, and it is not without a mean curvature.
    test : ExpansionTest, optional
        Result of `expansion_test` for the data, if already computed.
    """
    if data.mean_curvature is None:
        if marginal is not None:
            return replace(data, marginal=marginal)
        return _noted(
            data,
            "not treated as a horizon, because k is unknown: if it is one, marginal=True gives its "
            "Hawking and its Kijowski-Liu-Yau energy",
        )
    test = test or expansion_test(data)
    expansion = f"the expansion is {test.largest_expansion:.2g} +- {test.expansion_error:.1g}"
    away = f"the estimated displacement of the horizon is {percent(test.displacement, 1)} of its radius"
    if test.inward and marginal is None:
        return _noted(
            replace(data, marginal=False),
            f"not treated as a horizon: {expansion}; k + p vanishes instead of k - p, as it does where K_ij "
            "has the opposite sign",
        )
    if not (test.is_small if marginal is None else marginal):
        if marginal is None:
            data = _noted(data, f"not a horizon: {expansion}, and {away}; k and p are used as given")
        return replace(data, marginal=False)
    # Factor 2: spin increases the displacement.
    data = replace(data, marginal=True, displacement=2.0 * test.displacement)
    if test.is_zero:
        return data
    if marginal:
        return _noted(data, f"treated as a horizon as requested, although {expansion}: {away}")
    return replace(
        _noted(
            data,
            f"treated as a horizon that was located inexactly, unless the slice is another one: "
            f"{expansion}, and {away}; the errors include "
            "the possibility that it is not a horizon; marginal=True or marginal=False decides",
        ),
        doubtful=True,
    )


def classify_surface(data: SurfaceData) -> SurfaceData:
    """Data of a surface that is not treated as a horizon, with a note if it may be one."""
    if data.mean_curvature is None:
        return data
    test = expansion_test(data)
    if not test.is_small:
        return data
    return _noted(
        data,
        f"this may be a horizon, as the expansion is {test.largest_expansion:.2g} +- "
        f"{test.expansion_error:.1g}: if it is one, marginal=True gives its energies",
    )


def _noted(data: SurfaceData, note: str) -> SurfaceData:
    return replace(data, notes=(*data.notes, note))
