"""Equatorial and polar circumferences of a horizon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import minimize_scalar

from isoembed.arrays import Floats
from isoembed.meshing.sphere import gauss_legendre
from isoembed.relativity.horizons.invariant_coordinate import (
    FEWEST_NODES,
    GROWTH,
    MOST_NODES,
    InvariantCoordinate,
)
from isoembed.reprs import short_repr
from isoembed.smooth.two_metric import TwoMetric, area_density, orthonormal_frame
from isoembed.smooth.uncertain import EXACT, Uncertainty
from isoembed.surface.estimate import Estimate

FINER = 8  # refinement factor of the nodes in searches for extrema


@short_repr
@dataclass(frozen=True)
class Circumferences:
    """Lengths of closed curves on a surface, in its unit of length.

    Attributes
    ----------
    equatorial : Estimate
        Length of the circle of latitude zeta = 0, which bisects the area.
    longest : Estimate
        Length of the longest circle of latitude.
    polar : Estimate
        Twice the length of a meridian, a line along the gradient of zeta from pole to pole; the mean over
        meridians if there is no symmetry.
    polar_bounds : tuple of float
        Lower and upper bound of twice the length of all meridians, including their error; both equal `polar`
        for an axisymmetric surface.
    """

    equatorial: Estimate
    longest: Estimate
    polar: Estimate
    polar_bounds: tuple[float, float]

    @classmethod
    def of(
        cls, metric: TwoMetric, zeta: InvariantCoordinate, relative_error: Uncertainty = EXACT
    ) -> Circumferences:
        """The circumferences of a metric with an invariant coordinate.

        Parameters
        ----------
        metric : TwoMetric
        zeta : InvariantCoordinate
        relative_error : Uncertainty
            Relative error of lengths.  The mean meridian averages it over the surface, a circle of latitude
            over one dimension only.
        """
        atlas = _Atlas.of(metric, zeta)
        max_nodes = 512 if zeta.axisymmetric else MOST_NODES
        n, before = FEWEST_NODES, np.full(2, np.inf)
        while True:
            speed, _ = atlas.circles(np.zeros(1), np.array([0.5 * np.pi]), atlas.around(n))
            values = np.array([2.0 * np.pi * speed.mean(), atlas.meridian(n)])
            change = np.abs(values - before)
            if np.all(change <= 1e-13 * values) or GROWTH * n > max_nodes:  # converged in the number of nodes
                break
            n, before = int(GROWTH * n), values
        mean = relative_error.mean
        # A circle averages over one dimension: geometric mean of the pointwise error and that of the mean.
        circle = max(mean, 2.0 * float(np.sqrt(relative_error.pointwise * mean)))
        # 1e-14: rounding errors of sums over nodes.
        errors = change + (1e-14 + zeta.error + np.array([circle, mean])) * values
        equatorial, polar = (Estimate(*pair) for pair in zip(values, errors, strict=True))
        longest = atlas.longest(n)
        longest = Estimate(max(longest.value, equatorial.value), longest.error + equatorial.error)
        if zeta.axisymmetric:
            return cls(equatorial, longest, polar, (polar.value, polar.value))
        bounds, fewer = atlas.meridian_bounds(n), atlas.meridian_bounds(int(n / GROWTH))
        low, high = bounds + (-1.0, 1.0) * (np.abs(bounds - fewer) + errors[1])
        return cls(
            equatorial, longest, polar, (float(np.clip(low, 0.0, polar.value)), float(max(high, polar.value)))
        )

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        named = {"equatorial": self.equatorial, "longest": self.longest, "polar": self.polar}
        return {
            **{name: estimate.value for name, estimate in named.items()},
            "polar_bounds": list(self.polar_bounds),
            "errors": {name: estimate.error for name, estimate in named.items()},
        }


@dataclass(frozen=True)
class _Atlas:
    """Polar coordinates about the poles of zeta, on a sphere mapped to the directions u by a boost.

    Attributes
    ----------
    frame : ndarray, shape (3, 3)
        Orthonormal rows: north pole (greatest zeta) of the unboosted sphere, direction of the boost, and
        their cross product.
    boost : float
        Velocity of the boost: the cosine of half the angle between the poles.
    """

    metric: TwoMetric
    zeta: InvariantCoordinate
    frame: Floats
    boost: float

    @classmethod
    def of(cls, metric: TwoMetric, zeta: InvariantCoordinate) -> _Atlas:
        north, south = zeta.poles
        axis = north - south
        axis /= np.linalg.norm(axis)
        middle = 0.5 * (north + south)
        boost = float(np.linalg.norm(middle))
        across = middle if boost > np.finfo(np.float64).eps else np.eye(3)[np.argmin(np.abs(axis))]
        across = across - (across @ axis) * axis
        across /= np.linalg.norm(across)
        frame = np.stack([axis, across, np.cross(axis, across)])
        return cls(metric, zeta, frame, boost)

    def around(self, n: int) -> int:
        """Number of nodes on each of n circles."""
        return 4 if self.zeta.axisymmetric else 2 * n  # circles are orbits of the symmetry

    def meridian(self, n: int) -> float:
        """Twice the mean length of meridians: ``2 int <1 / |grad zeta|> dzeta``, with means over circles.

        Each meridian is weighted by the area next to it; the area per zeta comes from Legendre moments.
        """
        x, weights = gauss_legendre(n)
        psi = 2.0 * np.pi / self.around(n) * np.arange(self.around(n))
        theta, psi = (a.ravel() for a in np.meshgrid(0.5 * np.pi * (1.0 + x), psi, indexing="ij"))
        u, along, across = self._placed(theta, psi)
        value, gradient = self.zeta.derivatives(u)
        slope, density = self._measured(u, gradient)
        dA = np.repeat(weights, self.around(n)) * density * np.linalg.norm(np.cross(along, across), axis=1)
        north, south = self.zeta.derivatives(np.stack(self.zeta.poles))[0]
        half = 0.5 * (north - south)
        l = np.arange(n // 2)
        P = legendre.legvander((value - south) / half - 1.0, l[-1])
        return float(2.0 * half * np.sum(dA / (slope * (P @ ((l + 0.5) * (dA @ P))))))

    def meridian_bounds(self, n: int) -> Floats:
        """Bounds (2,) of twice the length of meridians, from the extrema of ``|grad zeta|`` on n circles."""
        x, weights = gauss_legendre(n)
        theta = 0.5 * np.pi * (1.0 + x)
        levels, fall = self._on_meridian(theta)
        _, slope = self.circles(levels, theta, self.around(n))
        # Fourier interpolation between the nodes, then parabolic interpolation.
        slope = np.fft.irfft(np.fft.rfft(slope, axis=1), FINER * slope.shape[1], axis=1) * FINER
        heights, greatest = np.arange(n), list[Floats]()
        for signed in (slope, -slope):
            k = signed.argmax(axis=1)
            before, there, after = (signed[heights, (k + step) % signed.shape[1]] for step in (-1, 0, 1))
            bend = np.minimum((before - there) + (after - there), -np.finfo(np.float64).tiny)
            greatest.append(there - (after - before) ** 2 / (8.0 * bend))
        return np.array([2.0 * np.sum(0.5 * np.pi * weights * fall / np.abs(most)) for most in greatest])

    def longest(self, n: int) -> Estimate:
        """Length of the longest circle of latitude, from n nodes."""
        m = FEWEST_NODES
        x, weights = gauss_legendre(m)
        theta = 0.5 * np.pi * (1.0 + x)
        speed, _ = self.circles(self._on_meridian(theta)[0], theta, self.around(m))
        # The longest circle is located with a polynomial in x through their lengths.
        l = np.arange(m)
        series = (l + 0.5) * (legendre.legvander(x, m - 1).T @ (weights * speed.mean(axis=1)))
        fine = np.linspace(-1.0, 1.0, FINER * m)
        k = int(np.clip(np.argmax(legendre.legval(fine, series)), 1, len(fine) - 2))
        place = minimize_scalar(
            lambda y: -legendre.legval(y, series), bounds=(fine[k - 1], fine[k + 1]), method="bounded"
        ).x
        # Vertex of the parabola through the lengths of three circles 1e-3 apart.
        start = 0.5 * np.pi * (1.0 + place) + 1e-3 * np.arange(-1.0, 2.0)
        speed, _ = self.circles(self._on_meridian(start)[0], start, self.around(n))
        below, there, above = 2.0 * np.pi * speed.mean(axis=1)
        bend = below - 2.0 * there + above
        if bend >= 0.0:  # by rounding, if the lengths of circles are equal
            return Estimate(max(below, there, above), abs(above - below) + bend)
        shift = (above - below) ** 2 / (8.0 * bend)
        return Estimate(there - shift, abs(shift))

    def _on_meridian(self, theta: Floats) -> tuple[Floats, Floats]:
        """Zeta (n,) at polar angles on the meridian psi = 0, and the absolute value of its derivative."""
        u, along, _ = self._placed(theta, np.zeros(len(theta)))
        value, gradient = self.zeta.derivatives(u)
        return value, np.abs(np.einsum("ni,ni->n", gradient, along))

    def _measured(self, u: Floats, gradient: Floats) -> tuple[Floats, Floats]:
        """Length (n,) of a gradient in the metric, and the area density relative to the unit sphere."""
        q = self.metric.tensor(u)
        along = np.einsum("nai,ni->na", orthonormal_frame(u, q), gradient)
        return np.linalg.norm(along, axis=1), area_density(q)

    def circles(self, levels: Floats, start: Floats, around: int) -> tuple[Floats, Floats]:
        """Speed in psi and ``|grad zeta|`` on m circles of latitude, each (m, around).

        The nodes are equidistant in the angle psi about the poles.  Newton's method starts from the polar
        angles theta (m,).
        """
        psi = np.tile(2.0 * np.pi / around * np.arange(around), len(levels))
        wanted, theta = np.repeat(levels, around), np.repeat(start, around)
        for _ in range(30):  # Newton's method
            u, along, across = self._placed(theta, psi)
            value, gradient = self.zeta.derivatives(u)
            fall = np.einsum("ni,ni->n", gradient, along)
            residual = wanted - value
            if np.abs(residual).max() <= 4e-15:  # rounding in zeta
                break
            theta = np.clip(theta + residual / fall, 0.5 * theta, 0.5 * (np.pi + theta))
        turn = -np.einsum("ni,ni->n", gradient, across) / fall
        velocity = turn[:, None] * along + across
        speed = np.sqrt(np.einsum("ni,nij,nj->n", velocity, self.metric.tensor(u), velocity))
        slope, _ = self._measured(u, gradient)
        return speed.reshape(-1, around), slope.reshape(-1, around)

    def _placed(self, theta: Floats, psi: Floats) -> tuple[Floats, Floats, Floats]:
        """Directions u (n, 3) at angles about the poles, and their derivatives in theta and psi."""
        axis, b, c = self.frame
        v, s = self.boost, np.sqrt((1.0 - self.boost) * (1.0 + self.boost))
        cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
        ring, tangent = np.cos(psi)[:, None] * b + np.sin(psi)[:, None] * c, np.sin(psi)[:, None] * -b
        tangent = tangent + np.cos(psi)[:, None] * c
        w, vectors = cos * axis + sin * ring, (cos * ring - sin * axis, sin * tangent)
        g = 1.0 / (1.0 + v * (w @ b))[:, None]
        u = g * (s * w + ((1.0 - s) * (w @ b) + v)[:, None] * b)
        along, across = (
            g * (s * t + (1.0 - s) * (t @ b)[:, None] * b - v * (t @ b)[:, None] * u) for t in vectors
        )
        return u, along, across
