"""Axisymmetric metrics: embedding as surfaces of revolution, and the bands that embed.

With x = cos(theta), s = 1 - x^2, q_tt = T and q_pp = s P, the surface has rho^2 = s P and dz/dx = sqrt(G),
``G = (q_tt - (d rho/d theta)^2) / s``.  T, P and G are smooth in x across the poles; where G < 0 there is no
surface of revolution.  Functions are piecewise Chebyshev series with adaptive bisection.

A component q_tp = sin(theta) Q is removed by the rotation ``phi + psi(theta)`` of each circle of latitude,
``d psi/d theta = q_tp / q_pp``: the metric is ``(q_tt - q_tp^2 / q_pp) dtheta^2 + q_pp (dphi + d psi)^2``.  A
smooth tensor has Q = s S with S smooth in x, so that ``d psi/dx = -S / P`` is smooth across the poles, too.

In a space of curvature k, rho is sn of the distance from the axis, G is reduced by k T P, because
q_tt (1 - k rho^2) replaces q_tt, and the arc length h along the axis satisfies
``dh/dx = sqrt(G) / (1 - k rho^2)``.
"""

# ruff: noqa: N806 (T and P with their derivatives, as above)
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import angles_of, directions_at
from isoembed.smooth.band import Band, checked_angles
from isoembed.smooth.piecewise import PIECE_DEGREE, Piecewise, Samples, fitted, value_at
from isoembed.smooth.two_metric import (
    NEAR_POLE,
    AngleMetric,
    TwoMetric,
    angle_components,
    are_definite,
    check_two_metric,
)
from isoembed.smooth.uncertain import EXACT
from isoembed.space import EUCLIDEAN, Space

Interval = tuple[float, float]

SAMPLES = 4096  # circles of latitude where series are checked: features of 2e-4 radians are found


@dataclass(frozen=True, eq=False)
class AxisymmetricEmbedding:
    """Surface of revolution about z with a given metric; its height z decreases with theta.

    Constructed by `of` or `from_components`.  A surface with non-monotonic height (dimples at the poles) is
    reflected so that the height decreases everywhere.  Properties of the whole surface raise `InvalidMetric`
    with the `explanation` as message if it does not embed.  In hyperbolic and spherical space points have
    ambient coordinates (`isoembed.Space`).

    Attributes
    ----------
    T, P, Q : Piecewise
        q_tt - q_tp^2 / q_pp, q_pp / sin^2(theta) and q_tp / sin(theta) over `unit` squared, as functions of
        x = cos(theta).
    unit : float
        Unit of length, about the largest circumferential radius.
    resolution : float
        Relative accuracy to which the metric is resolved as a smooth function.
    space : Space
        Ambient space, by default Euclidean; change it with `dataclasses.replace`.
    """

    T: Piecewise = field(repr=False)
    P: Piecewise = field(repr=False)
    Q: Piecewise = field(repr=False)
    unit: float
    resolution: float
    space: Space = EUCLIDEAN

    @classmethod
    def of(
        cls, metric: TwoMetric, tolerance: float = 1e-8, *, space: Space = EUCLIDEAN
    ) -> AxisymmetricEmbedding:
        """Embedding of an axisymmetric metric on the sphere.

        Parameters
        ----------
        metric : TwoMetric
        tolerance : float
            Largest variation of components along a circle of latitude, relative to the largest component.
        space : Space

        Raises
        ------
        InvalidMetric
            The metric is not axisymmetric about z, not positive definite, conical at a pole or otherwise not
            smooth; the message says where and by how much.
        """
        check_two_metric(metric)

        def components(x: Floats) -> Floats:
            u = directions_at(x, 0.0)
            q = angle_components(u, metric.tensor(u))
            tt, tp, pp = q[:, 0, 0], q[:, 0, 1], q[:, 1, 1]
            bad = np.flatnonzero(~are_definite(tt, tp, pp))
            if bad.size:
                i = int(bad[0])
                mixed = abs(tp[i]) > tolerance * abs(pp[i])
                names = f"q_tt, {'q_tp / sin(theta), ' if mixed else ''}q_pp / sin^2(theta)"
                values = (tt[i], *([tp[i]] if mixed else []), pp[i])
                raise InvalidMetric(
                    f"{names} = {', '.join(f'{value:.6g}' for value in values)} at"
                    f" theta = {_theta(x[i]):.6g}: that is not a positive metric"
                )
            # Q may vanish, but a series needs a scale: fit P + Q.
            return np.stack([tt - tp * (tp / pp), pp, pp + tp])

        _check_symmetry(metric, tolerance)
        scale = float(components(np.linspace(-1.0, 1.0, 65))[1].max())
        (T, P, sheared), resolution = fitted(
            lambda x: components(x) / scale,
            np.array([-1.0, 0.0, 1.0]),
            weighted=False,
            samples=_samples(lambda x: components(x) / scale),
        )
        Q = Piecewise(P.breaks, sheared.coefficients - P.coefficients)
        # Errors of lengths grow at the poles.
        length_error = 20.0 * float(getattr(metric, "error", EXACT).pointwise)
        cones = []
        for name, x in (("south", -1.0), ("north", 1.0)):
            t, p, q = (value_at(f, x) for f in (T, P, Q))
            # A larger difference of T and P at a pole is a cone.
            allowed = max(1e-7, 10.0 * resolution, length_error) * p
            cones.append(p - t)
            if abs(t - p) > allowed:
                raise InvalidMetric(
                    f"the metric is conical at the {name} pole:"
                    f" q_tt sin^2(theta) / q_pp = {t / p:.9g} there, not 1"
                )
            if abs(q) > allowed:
                raise InvalidMetric(
                    f"the metric is not smooth at the {name} pole:"
                    f" q_tp sin(theta) / q_pp = {q / p:.9g} there, not 0"
                )
        if length_error > 1e-7:  # remove cones within the errors of the metric
            slope, straight = 0.5 * np.diff(cones), np.zeros_like(T.coefficients)
            straight[0] = np.mean(cones) + 0.5 * slope * (T.breaks[:-1] + T.breaks[1:])
            straight[1] = 0.5 * slope * np.diff(T.breaks)
            T = Piecewise(T.breaks, T.coefficients + straight)
            resolution = max(resolution, float(np.abs(cones).max()))
        return cls(T, P, Q, float(np.sqrt(scale)), resolution, space)

    @classmethod
    def from_components(
        cls,
        q_tt: Callable[[Floats], ArrayLike],
        q_pp: Callable[[Floats], ArrayLike],
        *,
        space: Space = EUCLIDEAN,
    ) -> AxisymmetricEmbedding:
        """Embedding from the components, in units of length^2, as functions of theta between 0 and pi.

        Raises
        ------
        InvalidMetric
            See `of`; or a component is not positive.
        """
        return cls.of(AngleMetric(lambda theta, _: (q_tt(theta), 0.0, q_pp(theta))), space=space)

    @property
    def area(self) -> float:
        """Area of the metric, defined whether or not the metric embeds."""
        return self._area(0.0, np.pi)

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA with H = (k1 + k2)/2 of the whole surface."""
        return self._whole.integrated_mean_curvature

    @property
    def embeds(self) -> bool:
        """Whether the whole surface is a surface of revolution."""
        return not self.obstruction

    @cached_property
    def obstruction(self) -> tuple[Interval, ...]:
        """Intervals of theta without a surface of revolution: G < 0.

        In Euclidean space, ``q_tt < (d rho/d theta)^2``.
        """
        return self._negative(lambda x: self._terms(x)[0], 1.0)

    def is_obstructed_beyond(self, error: float) -> bool:
        """Whether no surface of revolution has the lengths of the metric within a relative error.

        Between two circles of latitude of such a surface the distance from the axis changes by at most the
        length of the meridian; this is tested on the intervals of `obstruction`.

        Parameters
        ----------
        error : float
            Relative error of the lengths of meridians and circles of latitude.
        """
        error = error + self.resolution
        nodes, weights = np.polynomial.legendre.leggauss(64)
        for start, stop in self.obstruction:
            theta = 0.5 * (start + stop + (stop - start) * nodes)
            length = 0.5 * (stop - start) * float(weights @ np.sqrt(self.T(np.cos(theta)))) * self.unit
            small, large = np.sort(self.rho([start, stop]))
            change = self.space.asn((1.0 - error) * large) - self.space.asn((1.0 + error) * small)
            if change > (1.0 + error) * length:
                return True
        return False

    @cached_property
    def negative_curvature(self) -> tuple[Interval, ...]:
        """Intervals of theta with K less than the curvature of space, where the surface is a saddle."""
        scale = float(np.abs(self._gauss(self._samples)).max())
        return self._negative(lambda x: self._gauss(x) - self._k, scale)

    @property
    def greatest_curvature(self) -> float:
        """Greatest curvature of space, in 1/length^2, that admits a surface of revolution.

        It is the minimum of ``(1 - (d rho/d s)^2) / rho^2``, with s the arc length along a meridian; at the
        poles this is K.  It is independent of `space`.
        """
        return self._greatest[0]

    @property
    def greatest_curvature_error(self) -> float:
        """Error of `greatest_curvature` from rounding or limited smoothness of the metric."""
        return self._greatest[1]

    @cached_property
    def _greatest(self) -> tuple[float, float]:
        """Greatest curvature of space and its error."""

        def bound(x: Floats) -> Floats:
            return self._terms(x)[0] / (self.T(x) * self.P(x)) + self._k

        at = partial(value_at, bound)
        x = self._samples
        values = bound(x)
        dips = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:]))
        places = [float(x[int(np.argmin(values))])]
        for i in dips:
            # The argument to half of the digits gives the minimum to full accuracy.
            options = {"xatol": 1e-9}
            places.append(
                float(minimize_scalar(at, bounds=(x[i + 1], x[i - 1]), method="bounded", options=options).x)
            )
        minimizer = min(places, key=at)
        size = value_at(self.T, minimizer) * value_at(self.P, minimizer)
        return at(minimizer) / self.unit / self.unit, self._noise / size / self.unit / self.unit

    @cached_property
    def bands(self) -> tuple[Band, ...]:
        """Maximal bands that embed, from north to south; a single one from 0 to pi if the whole embeds."""
        edges = [0.0, *(theta for interval in self.obstruction for theta in interval), np.pi]
        pairs = zip(edges[::2], edges[1::2], strict=True)
        return tuple(Band(self, start, stop) for start, stop in pairs if stop > start)

    @property
    def explanation(self) -> str:
        """Sentence on whether the surface embeds, and if not, where and why not, and which bands do."""
        curved = not self.space.is_euclidean
        where = f" in {self.space.name} space of curvature {self.space.curvature:.9g}" if curved else ""
        q_tt = "q_tt (1 - k rho^2)" if curved else "q_tt"
        if self.embeds:
            return (
                f"the metric is that of a surface of revolution{where}:"
                f" {q_tt} >= (d rho/d theta)^2 for all theta"
            )
        part = sum(band.area for band in self.bands) / self.area
        saddles = _listed(self.negative_curvature)
        reason = (
            f" (K < k for {saddles}; K >= k at the poles of every surface of revolution)"
            if curved
            else ", as the cap on one side of the circle of latitude has negative total curvature"
            f" (K < 0 for {saddles}; K >= 0 at the poles of every surface of revolution)"
        )
        return (
            f"no surface of revolution{where} has this metric for {_listed(self.obstruction)}: there {q_tt} <"
            f" (d rho/d theta)^2{reason}; {_listed([(band.start, band.stop) for band in self.bands])} embeds,"
            f" {100.0 * part:.6g} % of the area;"
            f" the whole surface embeds in a space of curvature {self.greatest_curvature:.9g} or less"
        )

    def rho(self, theta: ArrayLike) -> Floats:
        """Circumferential radius (n,) of the circle at theta (n,), defined whether or not the metric embeds.

        This is the distance from the axis in R^3, and sn of the distance in hyperbolic and spherical space.
        """
        theta = checked_angles(theta)
        return self.unit * np.sin(theta) * np.sqrt(self.P(np.cos(theta)))

    def z(self, theta: ArrayLike) -> Floats:
        """Height (n,) of the whole surface at theta (n,), zero at half its extent."""
        return self._whole.z(theta)

    def twist(self, theta: ArrayLike) -> Floats:
        """Azimuth psi (n,) of the coordinate meridian phi = 0 on the circle at theta (n,).

        It is zero at the north pole, and everywhere if q_tp = 0; bands have the same twist.
        """
        return self._twist(np.cos(checked_angles(theta)))

    def points(self, u: Floats) -> Floats:
        """Points (n, 3) of the whole surface at unit vectors u (n, 3)."""
        z = self.z(angles_of(u)[0])
        p = self.unit * np.sqrt(self.P(u[:, 2]))
        psi = self._twist(u[:, 2])
        c, s = p * np.cos(psi), p * np.sin(psi)
        return np.stack([c * u[:, 0] - s * u[:, 1], s * u[:, 0] + c * u[:, 1], z], axis=1)

    def gaussian_curvature(self, theta: ArrayLike) -> Floats:
        """K (n,) of the metric at theta (n,), in 1/length^2."""
        return self._gauss(np.cos(checked_angles(theta))) / self.unit / self.unit

    def mean_curvature(self, theta: ArrayLike) -> Floats:
        """H = (k1 + k2)/2 (n,) at theta (n,), in 1/length: infinite on edges of bands, NaN outside."""
        x = np.cos(checked_angles(theta))
        G, _ = self._terms(x)
        K = self._gauss(x) - self._k
        k2 = np.sqrt(np.where(G > 0.0, G, np.nan) / (self.T(x) * self.P(x)))
        # K - k = k1 k2.  At edges of bands k2 = 0 and K - k != 0; if both vanish at a pole, so does k1.
        edge = (G <= 0.0) & (-self._noise <= G)
        limit = np.where(np.abs(K) <= np.sqrt(self._noise), 0.0, np.copysign(np.inf, K))
        return np.where(edge, limit, 0.5 * (K / k2 + k2)) / self.unit

    @cached_property
    def _whole(self) -> Band:
        if not self.embeds:
            raise InvalidMetric(self.explanation)
        return self.bands[0]

    @property
    def _k(self) -> float:
        """Curvature of space in units of `unit`."""
        return self.space.curvature * self.unit * self.unit

    @property
    def _noise(self) -> float:
        return max(1e-11, 1e3 * self.resolution)  # noise of G and K, as differentiation loses digits

    @cached_property
    def _derivatives(self) -> tuple[Piecewise, Piecewise, Piecewise]:
        """P' and P'', T'."""
        P_x = self.P.derivative()
        return P_x, P_x.derivative(), self.T.derivative()

    @cached_property
    def _difference(self) -> _OverSquaredSine:
        """(T - P) / s."""
        return _OverSquaredSine(Piecewise(self.T.breaks, self.T.coefficients - self.P.coefficients))

    @cached_property
    def _twist(self) -> Callable[[Floats], Floats]:
        """Angle psi as a function of x."""
        if np.abs(self.Q.coefficients).max() <= self.resolution:
            return np.zeros_like
        slope = _OverSquaredSine(self.Q)
        # Absolute accuracy of angles: 1 is added for the scale.
        (density,), _ = fitted(lambda x: 1.0 + (slope(x) / self.P(x))[None, :], self.Q.breaks, weighted=True)
        below = density.primitive()
        whole = value_at(below, 1.0)
        return lambda x: (whole - below(x)) - (1.0 - x)

    def _terms(self, x: Floats) -> tuple[Floats, Floats]:
        """G and d rho/d theta at x."""
        s = (1.0 - x) * (1.0 + x)
        T, P, P_x = self.T(x), self.P(x), self._derivatives[0](x)
        E = self._difference(x)
        G = E + P + x * P_x - s * P_x * P_x / (4.0 * P) - self._k * T * P
        return G, (x * P - 0.5 * s * P_x) / np.sqrt(P)

    def _gauss(self, x: Floats) -> Floats:
        """K at x: the derivative of the cosine of the meridian's slope, over the area element."""
        s = (1.0 - x) * (1.0 + x)
        T, P = self.T(x), self.P(x)
        P_x, P_xx, T_x = (f(x) for f in self._derivatives)
        N = x * P - 0.5 * s * P_x
        return (P + 2.0 * x * P_x - 0.5 * s * P_xx - 0.5 * N * (P_x / P + T_x / T)) / (T * P)

    @cached_property
    def _area_beyond(self) -> Piecewise:
        """Area below x over 2 pi."""
        (density,), _ = fitted(
            lambda x: np.sqrt(self.T(x) * self.P(x))[None, :], self.T.breaks, weighted=True
        )
        return density.primitive()

    def _area(self, start: float, stop: float) -> float:
        below = self._area_beyond(np.cos(np.array([start, stop])))
        return float(2.0 * np.pi * (below[0] - below[1])) * self.unit * self.unit

    @cached_property
    def _samples(self) -> Floats:
        """Sample points x in decreasing order from 1 to -1, with a density that resolves the pieces."""
        nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(2 * PIECE_DEGREE) / (2 * PIECE_DEGREE))
        x = (self.T.breaks[:-1, None] + np.diff(self.T.breaks)[:, None] * nodes).ravel()
        return np.concatenate([[1.0], x[::-1]])

    def _negative(self, f: Callable[[Floats], Floats], scale: float) -> tuple[Interval, ...]:
        """Intervals of theta on which f(x) < 0 beyond rounding."""
        x, at = self._samples, partial(value_at, f)
        values = f(x)
        # f may have a pair of roots between samples where it is small compared with its differences.
        inner, smaller = values[1:-1], np.minimum(values[:-2], values[2:])
        larger = np.maximum(values[:-2], values[2:])
        dips = np.flatnonzero((inner > 0.0) & (inner <= smaller) & (inner <= larger - inner)) + 1
        lowest = [minimize_scalar(at, bounds=(x[i + 1], x[i - 1]), method="bounded").x for i in dips]
        x = np.sort(np.append(x, lowest))[::-1]
        values = f(x)
        below = values < 0.0
        turns = np.flatnonzero(below[1:] != below[:-1])
        roots = [brentq(at, x[i], x[i + 1], xtol=1e-300) for i in turns]
        edges = np.array([*([1.0] if below[0] else []), *roots, *([-1.0] if below[-1] else [])])
        found = []
        for upper, lower in edges.reshape(-1, 2):
            inside = values[(x <= upper) & (x >= lower)]
            if inside.size and inside.min() < -self._noise * scale:
                found.append((_theta(upper), _theta(lower)))
        return tuple(found)


class _OverSquaredSine:
    """Quotient f / (1 - x^2) of a piecewise series f that vanishes at both ends, 1 and -1."""

    def __init__(self, f: Piecewise) -> None:
        self._f = f
        width = np.diff(f.breaks)
        self._first = chebyshev.chebdiv(f.coefficients[:, 0], [1.0, 1.0])[0] * (2.0 / width[0])
        self._last = chebyshev.chebdiv(f.coefficients[:, -1], [1.0, -1.0])[0] * (2.0 / width[-1])

    def __call__(self, x: Floats) -> Floats:
        """Values at x (n,), including the ends."""
        south, north = x < self._f.breaks[1], x > self._f.breaks[-2]
        middle = ~(south | north)
        values = np.empty_like(x)
        values[middle] = self._f(x[middle]) / ((1.0 - x[middle]) * (1.0 + x[middle]))
        values[south] = chebyshev.chebval(self._f.local(x[south])[1], self._first) / (1.0 - x[south])
        values[north] = chebyshev.chebval(self._f.local(x[north])[1], self._last) / (1.0 + x[north])
        return values


def _samples(f: Callable[[Floats], Floats]) -> Samples:
    """Values of f at `SAMPLES` circles of latitude, except where metrics in angles are extrapolated."""
    theta = np.pi / SAMPLES * (np.arange(SAMPLES)[::-1] + 0.5)
    theta = theta[np.sin(theta) >= NEAR_POLE]
    # q_pp is often a difference, divided by sin^2(theta).
    return Samples(np.cos(theta), f(np.cos(theta)), 2.0 * np.finfo(float).eps / np.sin(theta) ** 2)


def _check_symmetry(metric: TwoMetric, tolerance: float) -> None:
    names = ("q_tt", "q_tp / sin(theta)", "q_pp / sin^2(theta)")
    theta = np.pi * (np.arange(24) + 0.5) / 24
    phi = 2.0 * np.pi * (np.arange(11) + 0.31) / 11  # 11 angles do not alias low orders to a constant
    u = directions_at(np.cos(theta)[:, None], phi).reshape(-1, 3)
    q = angle_components(u, metric.tensor(u)).reshape(24, 11, 4)[:, :, [0, 1, 3]].transpose(2, 0, 1)
    scale = float(np.abs(q[[0, 2]]).max())
    variation = (q.max(axis=2) - q.min(axis=2)) / scale
    if not variation.max() <= tolerance:
        k, i = divmod(int(np.argmax(variation)), len(theta))
        raise InvalidMetric(
            f"the metric is not axisymmetric about z: at theta = {theta[i]:.6g}, {names[k]} varies with phi"
            f" by {variation[k, i]:.3g} of the largest component"
        )


def _theta(x: float) -> float:
    return float(np.arctan2(np.sqrt((1.0 - x) * (1.0 + x)), x))


def _listed(intervals: Sequence[Interval]) -> str:
    words = []
    for start, stop in intervals:
        lower = f"{start:.6g} < " if start > 0.0 else ""
        upper = f" < {stop:.6g}" if stop < np.pi else ""
        one_sided = f"theta > {start:.6g}" if lower else "all theta"
        words.append(f"{lower}theta{upper}" if upper else one_sided)
    return " and ".join(words) or "no theta"
