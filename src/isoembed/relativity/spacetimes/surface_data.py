"""Data of a surface for quasi-local energies: induced metric, mean curvature, momentum."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity.spacetimes.checks import written
from isoembed.reprs import short_repr
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.two_metric import TwoMetric, area_density, check_two_metric
from isoembed.smooth.uncertain import EXACT, UncertainFunction, Uncertainty
from isoembed.smooth.user_functions import real_values


@short_repr
@dataclass(frozen=True)
class SurfaceData:
    """Closed surface in a slice of spacetime, as functions of the direction u on the unit sphere.

    Errors of functions of type `UncertainFunction` are propagated to the energies; others are treated as
    exact.  For a metric on a grid, arrays (n, m) at its nodes may replace functions.

    Attributes
    ----------
    metric : TwoMetric
        Induced metric of the surface.
    mean_curvature : callable, optional
        Takes u (n, 3) and returns ``k = k1 + k2`` (n,) of the surface in the slice, for the outward normal:
        2 / r for a sphere in flat space.
    momentum : callable, optional
        Takes u and returns ``p = K_ij (gamma^ij - n^i n^j)`` (n,), the trace over the surface of the slice's
        extrinsic curvature; the mean curvature vector has the norm ``sqrt(k^2 - p^2)``.  The sign of p is
        irrelevant.  None if p vanishes, as in a time-symmetric slice.
    normal_momentum : callable, optional
        Takes u and returns ``j = K(., n)``, n the outward normal in the slice, as tangent vectors (n, 3)
        whose products with velocities of u are its values; on a grid, the components (2, n, m) along theta
        and phi.  None if it vanishes or is not known.  It determines the spin; among the energies only the
        Christodoulou mass and the Wang-Yau energy depend on it.
    angular_momentum : float, optional
        J, in units of length^2, if known; otherwise it is computed from ``normal_momentum`` by
        `isoembed.relativity.find_spin`.
    charge : float
        Q, in units of length.
    marginal : bool
        Whether the surface is a horizon: k^2 = p^2 by definition, whatever their computed values.
    doubtful : bool
        Whether a marginal surface may not be a horizon, so that the computed k^2 - p^2 counts as its error.
    displacement : float
        Relative error of lengths from the displacement of a marginal surface from the horizon.
    relative_error : float, optional
        Relative mean error of lengths; by default the error estimate of a metric on a grid, and 0 for other
        metrics.
    shape : callable, optional
        Takes u and returns the points (n, 3) of the surface in nearly Cartesian coordinates of the slice,
        with which the embedded surface is aligned.  None if not known; it is then aligned with the
        directions.
    gaussian_curvature : callable, optional
        Takes u and returns K (n,) from a source other than the metric, for comparison; see
        `isoembed.relativity.CurvatureCheck`.
    name : str
        Name for reports.
    notes : tuple of str
        Remarks on the interpretation of the numbers, passed on to the energies.
    axis : three floats, optional
        Unit vector of a requested axis for J, which is then ``angular_momentum``.  By default the axis is
        computed.
    torque : callable, optional
        Takes u and returns ``K(e x (X - center), n)`` (n, 3), e the unit vectors along the coordinates x, y
        and z of the slice: 8 pi times the angular momentum densities about these axes.  None without such
        coordinates.
    electromagnetic_angular_momentum : float, optional
        Electromagnetic part of J about the axis of the spin, ``int (A . phi) *F / 4 pi``, if known, as
        ``normal_momentum`` gives the part of K_ij only.  Zero without charge.

    Raises
    ------
    InvalidParameter
        k, p or K(., n) is not a function, and the metric is not on a grid; or the relative error is negative
        or not a number.
    InvalidMetric
        Arrays do not match the grid or are not finite, or the grid is too coarse for them.
    """

    metric: TwoMetric
    mean_curvature: Callable[[Floats], Floats] | None = None
    momentum: Callable[[Floats], Floats] | None = None
    normal_momentum: Callable[[Floats], Floats] | None = None
    angular_momentum: float | None = None
    charge: float = 0.0
    marginal: bool = False
    doubtful: bool = False
    displacement: float = 0.0
    relative_error: float = None  # type: ignore[assignment] # a number once the data are made
    shape: Callable[[Floats], Floats] | None = None
    gaussian_curvature: Callable[[Floats], Floats] | None = None
    name: str = ""
    notes: tuple[str, ...] = ()
    axis: tuple[float, float, float] | None = None
    torque: Callable[[Floats], Floats] | None = None
    electromagnetic_angular_momentum: float | None = None

    def __post_init__(self) -> None:
        check_two_metric(self.metric)
        named = {"mean_curvature": "k", "momentum": "p", "normal_momentum": "j", "gaussian_curvature": "K"}
        for field, name in named.items():
            object.__setattr__(self, field, self._function(getattr(self, field), field, name))
        if isinstance(self.metric, GridMetric):
            assumed = (
                ("K(., n) is given and p is not: p is assumed to be 0",)
                if self.mean_curvature and self.normal_momentum and not self.momentum
                else ()
            )
            notes = (*self.metric.notes, *assumed, *self.notes)
            object.__setattr__(self, "notes", tuple(dict.fromkeys(notes)))
        if self.relative_error is None:
            object.__setattr__(self, "relative_error", self._metric_error.mean)
        if not self.relative_error >= 0.0:
            raise InvalidParameter(f"the relative_error is {self.relative_error!r}: it must not be negative")
        self._check_resolved()

    @classmethod
    def from_grid(
        cls,
        theta: ArrayLike,
        phi: ArrayLike,
        q: Sequence[ArrayLike],
        k: ArrayLike | None = None,
        p: ArrayLike | None = None,
        j: Sequence[ArrayLike] | None = None,
        *,
        name: str = "",
    ) -> SurfaceData:
        """Surface with metric, k, p and K(., n) at the nodes of a grid, with their errors.

        Parameters
        ----------
        theta, phi : array_like, shapes (n,), (m,)
            See `isoembed.smooth.GridMetric`.
        q : three array_like, shape (n, m)
            Components q_tt, q_tp and q_pp of the metric.
        k, p : array_like, shape (n, m), optional
            See ``mean_curvature`` and ``momentum``.
        j : two array_like, shape (n, m), optional
            Components of K(., n) along theta and phi.
        name : str
            Name for reports.

        Raises
        ------
        InvalidMetric
            Arrays do not match, are not finite or not a metric, or the grid is too coarse.

        Examples
        --------
        >>> theta, q = [0.3, 1.1, 2.0, 2.8], np.ones((4, 1))
        >>> sphere = SurfaceData.from_grid(theta, [0.0], (q, 0 * q, np.sin(theta)[:, None] ** 2), k=2 * q)
        >>> sphere.lengths_error.mean < 1e-12
        True
        """
        if len(q) != 3:
            raise InvalidMetric(f"q has {len(q)} components, not the three q_tt, q_tp and q_pp")
        return cls(GridMetric(theta, phi, *q), k, p, j, name=name)  # type: ignore[arg-type] # arrays: see above

    def in_coordinates(self, coordinates: SphereMap) -> SurfaceData:
        """Data as functions of the new directions v of a map u = F(v), with the same errors."""

        def scalar(function: Callable[[Floats], Floats] | None) -> Callable[[Floats], Floats] | None:
            return _composed(function, lambda f, v: f(coordinates.forward(v)))

        def one_form(f: Callable[[Floats], Floats], v: Floats) -> Floats:
            return np.einsum("nki,nk->ni", coordinates.differential(v), f(coordinates.forward(v)))

        return replace(
            self,
            metric=metric_in(self.metric, coordinates),
            mean_curvature=scalar(self.mean_curvature),
            momentum=scalar(self.momentum),
            normal_momentum=_composed(self.normal_momentum, one_form),
            shape=scalar(self.shape),
            gaussian_curvature=scalar(self.gaussian_curvature),
            torque=scalar(self.torque),
        )

    @property
    def lengths_error(self) -> Uncertainty:
        """Relative errors of lengths."""
        return Uncertainty(max(self.relative_error, self._metric_error.pointwise), self.relative_error)

    @property
    def _metric_error(self) -> Uncertainty:
        """Error of lengths estimated by the metric itself, as on grids and for surfaces in slices."""
        error = getattr(self.metric, "error", None)
        return error if isinstance(error, Uncertainty) else EXACT

    def _function(
        self, values: Callable[[Floats], Floats] | ArrayLike | None, field: str, name: str
    ) -> Callable[[Floats], Floats] | None:
        if values is None or callable(values):
            return values
        if not isinstance(self.metric, GridMetric):
            raise InvalidParameter(
                f"the {field} is a {type(values).__name__}: with a metric that is not on a grid, it must be "
                "a function of unit vectors u (n, 3)"
            )
        if field != "normal_momentum":
            return self.metric.function(values, name)
        components: list[ArrayLike] = list(values) if isinstance(values, Iterable) else []
        if len(components) != 2:
            raise InvalidMetric(f"j has {len(components)} components, not the two for theta and phi")
        meridional, azimuthal = components
        return self.metric.one_form(meridional, azimuthal, name)

    def _check_resolved(self) -> None:
        """Check that the grid resolves the functions."""
        errors = {
            "k": error_of(self.mean_curvature).pointwise,
            "p": error_of(self.momentum).pointwise,
            "j": error_of(self.normal_momentum).pointwise,
        }
        if not (isinstance(self.metric, GridMetric) and any(errors.values())):
            return
        u = fibonacci_directions(200)
        radius = float(np.sqrt(np.mean(area_density(self.metric.tensor(u)))))
        errors["j"] /= radius
        for name, error in errors.items():
            if error > 1.0 / radius:  # half of the mean curvature of a sphere
                raise InvalidMetric(
                    f"{name} is uncertain by {error:.2g} between the nodes of its grid, by its highest "
                    f"Fourier coefficients, and 2 / r is {2.0 / radius:.2g}: the grid is too coarse"
                )


def _composed(
    function: Callable[[Floats], Floats] | None,
    change: Callable[[Callable[[Floats], Floats], Floats], Floats],
) -> Callable[[Floats], Floats] | None:
    """``change(function, .)`` with the errors of the function, or None without a function."""
    if function is None:
        return None
    if isinstance(function, UncertainFunction):
        return UncertainFunction(partial(change, function.values), function.error)
    return partial(change, function)


def values_of(function: Callable[[Floats], ArrayLike], u: Floats, name: str) -> Floats:
    """Checked values (n,) of a function at unit vectors u (n, 3).

    Raises `InvalidParameter`: the values have a wrong shape, or one is not finite; the message contains
    the name.
    """
    return _checked(function, u, name, (len(u),))


def momentum_of(data: SurfaceData, u: Floats) -> Floats:
    """Checked momentum p (n,) of a surface at unit vectors u (n, 3), 0 if not given; see `values_of`."""
    return np.zeros(len(u)) if data.momentum is None else values_of(data.momentum, u, "the momentum")


def normal_momentum_of(data: SurfaceData, u: Floats) -> Floats:
    """Checked K(., n) (n, 3) of a surface at unit vectors u (n, 3), 0 if not given; see `values_of`."""
    if data.normal_momentum is None:
        return np.zeros_like(u)
    return _checked(data.normal_momentum, u, "K(., n)", u.shape)


def _checked(function: Callable[[Floats], ArrayLike], u: Floats, name: str, shape: tuple[int, ...]) -> Floats:
    values = real_values(name, function, u)
    if values.shape != shape:
        raise InvalidParameter(f"{name} at {len(u)} directions has the shape {values.shape}, not {shape}")
    bad = ~np.isfinite(values.reshape(len(u), -1)).all(axis=1)
    if bad.any():
        i = int(np.argmax(bad))
        raise InvalidParameter(f"{name} in the direction {written(u[i])} is {values[i]}: it must be finite")
    return values


def error_of(function: Callable[[Floats], Floats] | None) -> Uncertainty:
    """Errors of a function, zero if it has none."""
    return function.error if isinstance(function, UncertainFunction) else EXACT
