"""Metrics on a (theta, phi) grid."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import directions_at
from isoembed.smooth.double_fourier import (
    STENCIL,
    DoubleFourier,
    around,
    exact_phi,
    exact_theta,
    inner_nodes,
)
from isoembed.smooth.pole_checks import check_series
from isoembed.smooth.poles import PoleSight
from isoembed.smooth.spectrum import SCATTER, Spectrum
from isoembed.smooth.two_metric import (
    ROUNDING,
    TwoMetric,
    angle_components,
    are_definite,
    from_angles,
    is_axisymmetric,
)
from isoembed.smooth.uncertain import UncertainFunction, Uncertainty

SEAM = 1e-6  # largest relative difference of the columns phi = 0 and phi = 2 pi
FINEST = 768  # angles theta on a meridian, at most, of a metric sampled for meshes


@dataclass(frozen=True, eq=False, init=False, repr=False)
class GridMetric:
    """Metric on the sphere from its coordinate components on a grid, interpolated by Fourier series.

    The truncation error decreases exponentially with the number of nodes if the metric is analytic.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Angles increasing from pole to pole: cell-centered, uniform with or without the poles, or
        Gauss-Legendre.
    phi : array_like, shape (m,)
        Uniform angles over one full turn, from any first angle; the end point may be repeated.  A single
        angle is for a metric symmetric about the z-axis.
    q_tt, q_tp, q_pp : array_like, shape (n, m)
        Coordinate components: ds^2 = q_tt dtheta^2 + 2 q_tp dtheta dphi + q_pp dphi^2, in units of length^2.
        Values at the poles, where q_tp and q_pp vanish, are ignored.

    Attributes
    ----------
    theta, phi, q_tt, q_tp, q_pp : ndarray
        Read-only copies; single-precision angles of a standard grid are replaced by the exact ones.

    Raises
    ------
    InvalidMetric
        The shapes do not match, the nodes are not such a grid, or the components at a node are not finite or
        not positive definite; the message names the first such node.  Or the tensor is not smooth at the
        poles; the message describes the behavior there and the likely mistake.
    """

    theta: Floats
    phi: Floats
    q_tt: Floats
    q_tp: Floats
    q_pp: Floats
    _field: DoubleFourier

    def __init__(
        self, theta: ArrayLike, phi: ArrayLike, q_tt: ArrayLike, q_tp: ArrayLike, q_pp: ArrayLike
    ) -> None:
        self._fill(theta, phi, q_tt, q_tp, q_pp)
        self.at_poles()
        self._check_between()

    def _fill(
        self, theta: ArrayLike, phi: ArrayLike, q_tt: ArrayLike, q_tp: ArrayLike, q_pp: ArrayLike
    ) -> None:
        inner, m = inner_nodes(theta), around(phi)
        angles = {"theta": exact_theta(theta), "phi": exact_phi(phi)}
        shape = (len(angles["theta"]), len(angles["phi"]))
        q = {
            name: _component(values, name, shape)
            for name, values in (("q_tt", q_tt), ("q_tp", q_tp), ("q_pp", q_pp))
        }
        for name, value in (angles | q).items():
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        self._check_nodes(inner, m)
        sin = np.sin(self.theta[inner])[:, None]
        Q = np.stack([self.q_tt[inner], self.q_tp[inner] / sin, self.q_pp[inner] / sin**2], axis=2)
        object.__setattr__(self, "_field", DoubleFourier(self.theta[inner], self.phi[:m], Q[:, :m]))

    @classmethod
    def sampled(cls, metric: TwoMetric, n: int, m: int) -> GridMetric:
        """Sample a metric on a cell-centered grid of n angles theta and m angles phi.

        Raises
        ------
        InvalidMetric
            The grid is too coarse for the metric, or the metric is not a smooth tensor.
        """
        grid = cls._sampled(metric, n, m)
        grid.at_poles()
        return grid

    @classmethod
    def _sampled(cls, metric: TwoMetric, n: int, m: int) -> GridMetric:
        """Samples of a metric, without checks at the poles."""
        theta, phi = (np.arange(n) + 0.5) * (np.pi / n), np.arange(m) * (2.0 * np.pi / m)
        sin, cos = np.sin(theta)[:, None], np.cos(theta)[:, None]
        u = np.stack(np.broadcast_arrays(sin * np.cos(phi), sin * np.sin(phi), cos), axis=2).reshape(-1, 3)
        Q = angle_components(u, metric.tensor(u)).reshape(n, m, 2, 2)
        grid = cls.__new__(cls)
        grid._fill(theta, phi, Q[..., 0, 0], sin * Q[..., 0, 1], sin**2 * Q[..., 1, 1])
        grid._check_between()
        return grid

    def __repr__(self) -> str:
        return f"GridMetric({len(self.theta)} x {len(self.phi)} nodes)"

    @property
    def truncation(self) -> float:
        """Highest Fourier coefficients relative to the largest: about the interpolation error."""
        return self._spectrum.tail / self._spectrum.largest

    @cached_property
    def error(self) -> Uncertainty:
        """Relative errors of lengths: truncation, noise, too few angles phi, and conflicts at the poles."""
        error = _error(self._spectrum, np.stack([self.q_tt, self.q_tp, self.q_pp]))
        half, odds = 0.5 / self._size, 0.5 * self.at_poles().jump
        return Uncertainty(half * error.pointwise + odds, half * error.mean + 0.5 * odds)

    def deviations(self, u: Floats) -> tuple[Floats, ...]:
        """Random changes (N, n, 3, 3) of the tensor at u (n, 3), from noise at the nodes of the error's size.

        See `isoembed.smooth.uncertain_curvature.DeviatingMetric`.
        """
        directions, values = np.asarray(u, dtype=np.float64), self._field.values
        random = np.random.default_rng(0)
        size = 2.0 * self._size * self.error.pointwise / SCATTER
        drawn = []
        for _ in range(12):  # enough for a root mean square to 20 %
            noise = DoubleFourier(self._field.theta, self._field.phi, size * random.normal(size=values.shape))
            drawn.append(from_angles(directions, *noise.at(directions).T))
        return (np.stack(drawn),)

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the errors, for reports."""
        count, spectrum = around(self.phi), self._spectrum
        # A fifth of the error deserves a note, rounding does not.
        level = max(0.2 * spectrum.error.mean, 1e-11 * spectrum.largest)
        if count == 1 or spectrum.unseen < level:
            return ()
        return (
            f"{count} angles phi do not resolve variations in phi as fast as those in theta, and the errors "
            "allow for them: for a metric that is symmetric about the z-axis, give one angle phi",
        )

    def at_poles(self) -> PoleSight:
        """Behavior of the metric at the poles.

        Raises
        ------
        InvalidMetric
            The tensor is not smooth there; the message describes the behavior and the likely mistake.
        """
        return check_series(self._field.theta, self._field.phi, self._field.values)

    def tensor(self, u: Floats) -> Floats:
        """Metric (n, 3, 3) at unit vectors u (n, 3); see `TwoMetric`."""
        u = np.asarray(u, dtype=np.float64)
        return from_angles(u, *self._field.at(u).T)

    def function(self, values: ArrayLike, name: str = "the function") -> UncertainFunction:
        """Interpolation of values (n, m) on the same grid, as a function of unit vectors (k, 3).

        Raises
        ------
        InvalidMetric
            The values have a wrong shape, or one is not finite; the message contains the name.
        """
        nodal = self._nodal(values, name)
        series = self._series(nodal[..., None], self.phi)
        return UncertainFunction(
            lambda u: series.at(np.asarray(u, dtype=np.float64))[:, 0],
            _error(Spectrum.of(series, _with_square), nodal),
        )

    def one_form(
        self, meridional: ArrayLike, azimuthal: ArrayLike, name: str = "the one-form"
    ) -> UncertainFunction:
        """Interpolation of a one-form from its components (n, m) along theta and phi on the same grid.

        The result maps unit vectors u (k, 3) to tangent vectors (k, 3), whose inner products with velocities
        of u are the values of the form.  Components at the poles are ignored.

        Raises
        ------
        InvalidMetric
            See `function`.
        """
        # The Cartesian components of an axisymmetric one-form depend on phi.  They need more than one angle;
        # as many as there are degrees in theta let the error estimate exclude unresolved orders.
        n = 2 * len(self.theta)
        angles = self.phi if len(self.phi) > 1 else self.phi + 2.0 * np.pi / n * np.arange(n)
        sin, cos = np.sin(self.theta)[:, None], np.cos(self.theta)[:, None]
        e_theta = np.stack(np.broadcast_arrays(cos * np.cos(angles), cos * np.sin(angles), -sin), axis=2)
        e_phi = np.stack(np.broadcast_arrays(-np.sin(angles), np.cos(angles), 0.0 * sin), axis=2)
        theta, phi = self._nodal(meridional, name), self._nodal(azimuthal, name)
        # Cartesian components are smooth across the poles, those along the angles are not.
        away = np.where(sin > 0.0, sin, 1.0)
        series = self._series(theta[..., None] * e_theta + (phi / away)[..., None] * e_phi, angles)

        def vectors(u: Floats) -> Floats:
            v = series.at(np.asarray(u, dtype=np.float64))
            return np.asarray(v - np.einsum("ni,ni->n", v, u)[:, None] * u)

        return UncertainFunction(vectors, _error(Spectrum.of(series), np.stack([theta, phi])))

    @cached_property
    def _spectrum(self) -> Spectrum:
        return Spectrum.of(self._field, _lengths)

    @cached_property
    def _size(self) -> float:
        """Area-weighted harmonic mean of the metric, which converts errors of components to relative ones."""
        unit = np.max(np.abs(self._field.table))
        Qtt, Qtp, Qpp = np.moveaxis(self._field.table / unit, 2, 0)
        rows = len(Qtt) - STENCIL - 1
        sin = np.abs(np.sin(np.pi / rows * (np.arange(len(Qtt)) - STENCIL // 2)))[:, None]
        root = np.sqrt(Qtt * Qpp - Qtp**2)
        return unit * float(2.0 * np.sum(sin * root) / np.sum(sin * (Qtt + Qpp) / root))

    def _nodal(self, values: ArrayLike, name: str) -> Floats:
        nodal = _component(values, name, (len(self.theta), len(self.phi)))
        finite = np.isfinite(nodal)
        if not finite.all():
            i, j = (int(k) for k in np.argwhere(~finite)[0])
            raise InvalidMetric(f"{name} is {nodal[i, j]} at theta[{i}], phi[{j}]")
        return nodal

    def _series(self, values: Floats, phi: Floats) -> DoubleFourier:
        """Series of values (n, m, c) at the angles theta of the nodes and given angles phi."""
        inner, m = inner_nodes(self.theta), around(phi)
        return DoubleFourier(self.theta[inner], phi[:m], values[inner, :m])

    def _check_nodes(self, inner: Mask, m: int) -> None:
        tt, tp, pp = self.q_tt, self.q_tp, self.q_pp
        bad = ~are_definite(tt, tp, pp) & inner[:, None]
        if bad.any():
            i, j = np.argwhere(bad)[0]
            finite = np.isfinite([tt[i, j], tp[i, j], pp[i, j]]).all()
            raise InvalidMetric(
                f"q_tt, q_tp, q_pp = {tt[i, j]:.6g}, {tp[i, j]:.6g}, {pp[i, j]:.6g} at node [{i}, {j}], "
                f"theta = {self.theta[i]:.6g}, phi = {self.phi[j]:.6g}: that is not "
                + ("a positive definite metric" if finite else "finite")
            )
        if m < len(self.phi):
            sin = np.sin(self.theta[inner])
            for name, q, power in (("q_tt", tt, 0), ("q_tp", tp, 1), ("q_pp", pp, 2)):
                jump = np.abs(q[inner, -1] - q[inner, 0]) / sin**power
                size = max(np.max(tt[inner]), np.max(pp[inner] / sin[:, None] ** 2))
                if np.max(jump) > SEAM * size:
                    i = int(np.flatnonzero(inner)[np.argmax(jump > SEAM * size)])
                    raise InvalidMetric(
                        f"{name}[{i}, {m}] = {q[i, m]:.6g} at phi = {self.phi[m]:.6g} is not "
                        f"{name}[{i}, 0] = {q[i, 0]:.6g} at the same point"
                    )

    def _check_between(self) -> None:
        """Check that the series is positive definite between the nodes, as on a sufficiently fine grid."""
        Qtt, Qtp, Qpp = np.moveaxis(self._field.table, 2, 0)
        scale = np.max(np.abs(self._field.table))
        bad = ~((Qtt > 0) & (Qpp > 0) & ((Qtt / scale) * (Qpp / scale) > (Qtp / scale) ** 2))
        if bad.any():
            raise InvalidMetric(
                f"between the {len(self.theta)} x {len(self.phi)} nodes the interpolated metric is not "
                f"positive definite (its highest Fourier coefficients are {self.truncation:.1g} of the "
                "largest): the grid is too coarse for it"
            )


def sampled_on_grid(metric: TwoMetric) -> TwoMetric:
    """Interpolation of a metric on a fine grid, accurate enough for meshes and fast to evaluate.

    If the metric is symmetric about the z-axis, the grid is as fine as the values on a meridian require.
    """
    try:
        if not is_axisymmetric(metric):
            return GridMetric._sampled(metric, 96, 192)
        theta = (np.arange(FINEST) + 0.5) * (np.pi / FINEST)
        u = directions_at(np.cos(theta), 0.0)
        exact = metric.tensor(u)
        for n in (FINEST // 8, FINEST // 4):
            with suppress(InvalidMetric):  # the grid is too coarse
                grid = GridMetric._sampled(metric, n, 1)
                # Everywhere relative to the local size: lengths at the tips of needles are short.
                errors, sizes = (np.abs(q).max(axis=(1, 2)) for q in (grid.tensor(u) - exact, exact))
                if (errors <= ROUNDING * sizes).all():
                    return grid
        return GridMetric._sampled(metric, FINEST, 1)
    except InvalidMetric:  # the grid is too coarse
        return metric


def _lengths(values: Floats) -> Floats:
    """Area density and mean squared stretch (k, 2) of components (k, 3) in a frame."""
    tt, tp, pp = values.T
    return np.stack([np.sqrt(np.maximum(tt * pp - tp**2, 0.0)), 0.5 * (tt + pp)], axis=1)


def _with_square(values: Floats) -> Floats:
    """Function (k, 1), and half of its square over its root mean square, as (k, 2)."""
    size = float(np.sqrt(np.mean(values**2)))
    return np.concatenate([values, 0.5 * values**2 / size], axis=1)


def _error(spectrum: Spectrum, values: Floats) -> Uncertainty:
    """Errors of a function from its spectrum and from single precision of its values at nodes."""
    error = spectrum.error
    # The rounding error of a constant is invisible in its spectrum.
    with np.errstate(over="ignore"):
        single = bool(np.all(values == values.astype(np.float32)))
    if not single or len(np.unique(values)) < 8:  # few values may be representable by chance
        return error
    rounding = float(np.finfo(np.float32).eps) * float(np.abs(values).max())
    return Uncertainty(error.pointwise + rounding, error.mean + 0.5 * rounding)


def _component(values: ArrayLike, name: str, shape: tuple[int, int]) -> Floats:
    array = np.asarray(values)
    if array.shape != shape or array.dtype.kind not in "iuf":
        raise InvalidMetric(
            f"{name} has the shape {array.shape} and the type {array.dtype}, "
            f"not {shape} numbers for {shape[0]} angles theta and {shape[1]} angles phi"
            + (": it looks transposed" if array.shape == shape[::-1] else "")
        )
    return array.astype(np.float64)
