"""Circumferences of a surface around and across the poles of its symmetry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import minimize_scalar

from isoembed.arrays import Floats
from isoembed.relativity.horizons.invariant_coordinate import InvariantCoordinate
from isoembed.smooth.two_metric import TwoMetric, area_density, orthonormal_frame
from isoembed.surface.estimate import Estimate
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class CircumferenceThresholds:
    """Thresholds of circumferences."""

    fewest: int = threshold(24, "count", "Circles of latitude, and half the nodes on each, to begin with.")
    denser: float = threshold(1.5, "relative", "Circles over those before.")
    highest: int = threshold(96, "count", "Circles after which there are no more.")
    highest_symmetric: int = threshold(512, "count", "The same for metrics symmetric about z.")
    around: int = threshold(4, "count", "Nodes on a circle there.")
    settled: float = threshold(1e-13, "relative", "Change by more nodes that is none.")
    rounding: float = threshold(1e-14, "relative", "Rounding in sums over nodes.")
    steps: int = threshold(30, "count", "Newton steps towards a circle, at most.")
    near: float = threshold(1e-14, "radians", "Step towards a circle that is none.")
    finer: int = threshold(8, "relative", "Places where the longest circle is sought, over the circles.")


CIRCUMFERENCE = CircumferenceThresholds()


@dataclass(frozen=True)
class Circumferences:
    """Lengths of closed curves on a surface, in its unit.

    Attributes
    ----------
    equatorial : Estimate
        Of the circle of latitude zeta = 0, which halves the area.
    longest : Estimate
        Of the longest circle of latitude.
    polar : Estimate
        Of two meridians, from pole to pole and back: lines along the gradient of zeta.  Without symmetry they
        differ, and this is a mean.
    polar_bounds : tuple of float
        Between these is twice the length of every meridian; both are `polar` where there is a symmetry.
    """

    equatorial: Estimate
    longest: Estimate
    polar: Estimate
    polar_bounds: tuple[float, float]

    @classmethod
    def of(cls, metric: TwoMetric, zeta: InvariantCoordinate, relative_error: float = 0.0) -> Circumferences:
        """The circumferences of a metric with an invariant coordinate.

        Parameters
        ----------
        metric : TwoMetric
        zeta : InvariantCoordinate
        relative_error : float
            The uncertainty of lengths.
        """
        t, atlas = CIRCUMFERENCE, _Atlas.of(metric, zeta)
        most = t.highest_symmetric if zeta.axisymmetric else t.highest
        n, before = t.fewest, np.full(3, np.inf)
        while True:
            values, bounds = atlas.lengths(n)
            change = np.abs(values - before)
            if np.all(change <= t.settled * values) or t.denser * n > most:
                break
            n, before = int(t.denser * n), values
        errors = change + (t.rounding + relative_error + zeta.error) * values
        equatorial, longest, polar = (Estimate(*pair) for pair in zip(values, errors, strict=True))
        return cls(equatorial, longest, polar, bounds)

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
    """Angles about the poles of zeta: w on a sphere where these are opposite is moved to u by a boost.

    Attributes
    ----------
    frame : ndarray, shape (3, 3)
        The direction of the pole of greatest zeta among the w, that of the boost, and one across both.
    boost : float
        Its velocity: the cosine of half the angle between the poles.
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

    def lengths(self, n: int) -> tuple[Floats, tuple[float, float]]:
        """Lengths of the equator, the longest of n circles and the mean meridian; bounds of the last."""
        around = CIRCUMFERENCE.around if self.zeta.axisymmetric else 2 * n
        x, weights = legendre.leggauss(n)
        theta = 0.5 * np.pi * (1.0 + x)
        # Circles through even heights on one meridian psi = 0, on which no zeta has to be solved for.
        u, along, _ = self._placed(theta, np.zeros(n))
        levels, gradient = self.zeta.derivatives(u)
        fall = np.abs(np.einsum("ni,ni->n", gradient, along))
        speed, slope, spread = self._circles(levels, theta, around)
        rate = (0.5 * np.pi * weights * fall)[:, None] / slope
        polar = 2.0 * float(np.average(rate, axis=1, weights=spread).sum())
        bounds = 2.0 * float(rate.min(axis=1).sum()), 2.0 * float(rate.max(axis=1).sum())
        # Their lengths as a polynomial in x tell the place of the longest.
        l = np.arange(n)
        series = (l + 0.5) * (legendre.legvander(x, n - 1).T @ (weights * speed.mean(axis=1)))
        fine = np.linspace(-1.0, 1.0, CIRCUMFERENCE.finer * n)
        k = int(np.clip(np.argmax(legendre.legval(fine, series)), 1, len(fine) - 2))
        place = minimize_scalar(
            lambda y: -legendre.legval(y, series), bounds=(fine[k - 1], fine[k + 1]), method="bounded"
        ).x
        start = np.array([theta[np.argmin(np.abs(levels))], 0.5 * np.pi * (1.0 + place)])
        chosen = np.array([0.0, self.zeta.derivatives(self._placed(start[1:], np.zeros(1))[0])[0][0]])
        equator, longest = 2.0 * np.pi * self._circles(chosen, start, around)[0].mean(axis=1)
        return np.array([equator, max(equator, longest), polar]), bounds

    def _circles(self, levels: Floats, start: Floats, around: int) -> tuple[Floats, Floats, Floats]:
        """Circles of latitude, each array (m, around) at even angles psi about the poles.

        The lengths of their velocities in psi; that of the gradient of zeta; and dA over dpsi dzeta.
        Newton's method starts from the angles theta (m,).
        """
        psi = np.tile(2.0 * np.pi / around * np.arange(around), len(levels))
        wanted, theta = np.repeat(levels, around), np.repeat(start, around)
        for _ in range(CIRCUMFERENCE.steps):
            u, along, across = self._placed(theta, psi)
            value, gradient = self.zeta.derivatives(u)
            fall = np.einsum("ni,ni->n", gradient, along)
            step = (wanted - value) / fall
            if np.abs(step).max() <= CIRCUMFERENCE.near:
                break
            theta = np.clip(theta + step, 0.5 * theta, 0.5 * (np.pi + theta))
        turn = -np.einsum("ni,ni->n", gradient, across) / fall
        q = self.metric.tensor(u)
        velocity = turn[:, None] * along + across
        speed = np.sqrt(np.einsum("ni,nij,nj->n", velocity, q, velocity))
        slope = np.linalg.norm(np.einsum("nai,ni->na", orthonormal_frame(u, q), gradient), axis=1)
        area = area_density(q) * np.linalg.norm(np.cross(along, across), axis=1)
        shape = len(levels), around
        return speed.reshape(shape), slope.reshape(shape), np.abs(area / fall).reshape(shape)

    def _placed(self, theta: Floats, psi: Floats) -> tuple[Floats, Floats, Floats]:
        """The directions u (n, 3) at angles about the poles, and their derivatives in theta and psi."""
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
