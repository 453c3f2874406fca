"""Star-shaped surfaces in a slice: the radius by direction in spherical harmonics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.spacetimes.checks import numbers, positive_number, vector, written
from isoembed.relativity.spacetimes.point_cloud import checked_points, seen_from
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.surface_errors import SurfaceErrors
from isoembed.relativity.spacetimes.surface_frame import SurfaceFrame, differential
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating, fitted, white
from isoembed.smooth.transforms import analyzed, trimmed
from isoembed.smooth.two_metric import area_density
from isoembed.smooth.uncertain import EXACT, UncertainFunction, Uncertainty
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class StarSurfaceThresholds:
    """Thresholds of surfaces in spherical harmonics."""

    first_degree: int = threshold(16, "count", "Degree in which a radius is sought first; it is doubled.")
    highest_degree: int = threshold(
        128, "count", "Degree above which harmonics of a function are not sought."
    )
    rounding: float = threshold(1e-15, "relative", "Rounding in the harmonics of a radius.")
    exact: float = threshold(1e-12, "relative", "Miss of a radius below which it is exact.")
    missed: float = threshold(1e-6, "relative", "Miss of a radius above which it is not smooth.")
    directions: int = threshold(200, "count", "Directions at which the miss of a radius is measured.")
    nodes: tuple[int, int] = threshold(
        (24, 48), "count", "Heights and angles at which a slice tells its errors."
    )
    settled: float = threshold(1e-13, "relative", "Change of an angular momentum by more nodes that is none.")


STAR = StarSurfaceThresholds()


@dataclass(frozen=True, eq=False)
class StarSurface:
    """The surface ``X(u) = center + r(u) u``, u the unit vectors.

    Attributes
    ----------
    center : three floats
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size,)
        Those of r, lengths.
    misfit : float
        How far r is from what it was made from, a length, root-mean-square: from the function at directions
        that were not used, or from the points.
    deviations : ndarray, shape (N, size), optional
        Of points: by what the coefficients may be off, drawn at random, in the harmonics of
        `isoembed.smooth.scattered_fit.deviating`; without them, noise of the size of the misfit.
    notes : tuple of str
        Which points were left out, for reports.

    Raises
    ------
    InvalidParameter
        The radius is not positive; the message names a direction.
    """

    center: Sequence[float]
    harmonics: Harmonics
    coefficients: Floats
    misfit: float = 0.0
    deviations: Floats | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector("the center", self.center))
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if coefficients.shape != (self.harmonics.size,):
            raise InvalidParameter(
                f"{self.harmonics.size} harmonics take as many coefficients, not {coefficients.shape}"
            )
        coefficients.setflags(write=False)
        object.__setattr__(self, "coefficients", coefficients)
        u, _ = gauss_rule(self.harmonics.degree + 2, 2 * self.harmonics.order + 2)
        _check_radius(u, self.radius(u))

    @classmethod
    def sphere(cls, center: Sequence[float], radius: float) -> StarSurface:
        """The coordinate sphere with this center and radius."""
        positive_number("the radius", radius)
        return cls(center, Harmonics(0, 0), np.array([radius * np.sqrt(4.0 * np.pi)]))

    @classmethod
    def from_radius(
        cls, radius: Callable[[Floats], ArrayLike], center: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> StarSurface:
        """Projection of a radius onto harmonics, up to the degree where only rounding or noise is left.

        Parameters
        ----------
        radius : callable
            Takes unit vectors u (n, 3) and returns r (n,); smooth.
        center : three floats

        Raises
        ------
        InvalidParameter
            A radius is not positive, or harmonics up to degree 128 miss it by more than a millionth; the
            message says which.

        Notes
        -----
        What is missed, where it is more than rounding, is the ``misfit``.
        """
        if not callable(radius):
            raise InvalidParameter(
                f"the radius is a {type(radius).__name__}, not a function of unit vectors u (n, 3); values r "
                "in some directions u are for from_points(center + r u, center), and a number is for sphere"
            )
        apart = fibonacci_directions(STAR.directions)
        expected = _radii(radius, apart)
        found: list[tuple[float, tuple[Harmonics, Floats, float]]] = []
        degree = STAR.first_degree
        while degree <= STAR.highest_degree:
            u, weights = gauss_rule(degree + 1, 2 * degree + 2)
            coefficients, harmonics = analyzed(_radii(radius, u), u, weights, degree)
            sizes = np.abs(coefficients) / abs(coefficients[0])
            tail = float(sizes[harmonics.labels[0] > 3 * degree // 4].max())
            coefficients, harmonics = trimmed(coefficients, harmonics, sizes > STAR.rounding / 4.0)
            error = (harmonics.values(apart) @ coefficients - expected) / expected.max()
            missed = float(np.abs(error).max())
            if missed <= STAR.missed:
                misfit = float(np.sqrt(np.mean(error**2)) * expected.max())
                found.append((missed, (harmonics, coefficients, misfit)))
                if tail <= STAR.rounding and missed <= STAR.exact:
                    return cls(center, *found[-1][1])
            degree *= 2
        if not found:
            raise InvalidParameter(
                f"the radius is not smooth enough for harmonics: those of degree {STAR.highest_degree} are "
                f"still {tail:.3g} of the mean, and miss it by {missed:.3g}; fit points instead"
            )
        # Harmonics that come no nearer would be noise, and their second derivatives loud noise.
        enough = 2.0 * min(missed for missed, _ in found)
        return cls(center, *next(fit for missed, fit in found if missed <= enough))

    @classmethod
    def from_angles(
        cls, radius: Callable[[Floats, Floats], ArrayLike], center: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> StarSurface:
        """Projection of a radius that is given by angles; see `from_radius`.

        Parameters
        ----------
        radius : callable
            Takes arrays theta and phi, in (0, pi) and [0, 2 pi), and returns r.  It is never called at the
            poles.
        center : three floats
        """

        def by_direction(u: Floats) -> ArrayLike:
            theta = np.arctan2(np.hypot(u[:, 0], u[:, 1]), u[:, 2])
            return np.broadcast_to(radius(theta, np.arctan2(u[:, 1], u[:, 0]) % (2.0 * np.pi)), theta.shape)

        return cls.from_radius(by_direction, center)

    @classmethod
    def from_points(
        cls, points: ArrayLike, center: Sequence[float], faces: Indices | None = None
    ) -> StarSurface:
        """Least squares fit of harmonics to points, weighted by the solid angles that they stand for.

        The degree is the one of least generalized cross-validation, at most 40.  Single outliers are left
        out, and named in the ``notes``; see `isoembed.smooth.scattered_fit.fitted`.

        Parameters
        ----------
        points : array_like, shape (m, 3)
            One on each ray from the center; points given twice do no harm.
        center : three floats
        faces : ndarray of int, shape (F, 3), optional
            The convex hull of the directions from the center, if it is at hand.

        Raises
        ------
        InvalidParameter
            The points are too few, not finite, at the center, or do not surround it.
        """
        c = vector("the center", center)
        x = checked_points(points)
        u, r, weights = seen_from(x, np.array(c), faces)
        used = weights > 0.0
        fit = fitted(u[used], r[used], weights[used])
        notes = tuple(
            f"point {i} at {written(x[i])} was left out: it lies {abs(apart):.3g} "
            f"{'outside' if apart > 0.0 else 'inside'} the surface that fits the others "
            f"({100.0 * abs(apart) / r[i]:.2g} % of its radius)"
            for i, apart in zip(np.flatnonzero(used)[fit.left_out], fit.apart, strict=True)
        )
        return cls(c, fit.harmonics, fit.coefficients, fit.misfit, fit.deviations, notes)

    @property
    def mean_radius(self) -> float:
        """The mean of the radius over all directions."""
        return float(self.coefficients[0] / np.sqrt(4.0 * np.pi))

    def radius(self, u: Floats) -> Floats:
        """The radius (n,) in the directions u (n, 3)."""
        return self.harmonics.derivatives(_directions(u), self.coefficients)[0]

    def points(self, u: Floats) -> Floats:
        """The points X (n, 3) in the directions u (n, 3)."""
        u = _directions(u)
        return np.array(self.center) + self.radius(u)[:, None] * u

    def differential(self, u: Floats) -> Floats:
        """The differential dX (n, 3, 3): ``dX @ v`` is the derivative of X along a tangent vector v."""
        u = _directions(u)
        r, slope, _ = self.harmonics.derivatives(u, self.coefficients)
        return differential(u, r, slope)

    def frame(self, geometry: ThreeGeometry, u: Floats) -> SurfaceFrame:
        """The local geometry of the surface in a slice, in the directions u (n, 3)."""
        u = _directions(u)
        r, slope, hessian = self.harmonics.derivatives(u, self.coefficients)
        return SurfaceFrame(geometry, u, np.array(self.center) + r[:, None] * u, r, slope, hessian)

    def _deviating(self, geometry: ThreeGeometry, u: Floats) -> Iterator[SurfaceFrame]:
        """Frames of surfaces that this one might be, for errors."""
        r, slope, hessian = self.harmonics.derivatives(u, self.coefficients)
        harmonics = deviating(self.harmonics)
        drawn = white(self.harmonics, self.misfit) if self.deviations is None else self.deviations
        for deviation in drawn:
            dr, d_slope, d_hessian = harmonics.derivatives(u, deviation)
            x = np.array(self.center) + (r + dr)[:, None] * u
            yield SurfaceFrame(geometry, u, x, r + dr, slope + d_slope, hessian + d_hessian)

    def metric(self, geometry: ThreeGeometry) -> InducedMetric:
        """The metric that the geometry induces on the surface."""
        return InducedMetric(self, geometry)

    def mean_curvature(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) for the outward normal, in the directions u (n, 3); 2 / r on a flat sphere."""
        return self.frame(geometry, u).mean_curvature()

    def momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,) in the directions u (n, 3)."""
        return self.frame(geometry, u).momentum()

    def normal_momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``K(., n)`` as tangent vectors (n, 3) of the unit sphere at u (n, 3): see `SurfaceData`."""
        return self.frame(geometry, u).normal_momentum()

    def expansion(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``theta_+ = k - p`` (n,) of the light rays that leave outward; zero on an apparent horizon."""
        frame = self.frame(geometry, u)
        return frame.mean_curvature() - frame.momentum()

    def angular_momentum(self, geometry: ThreeGeometry, axis: Sequence[float]) -> float:
        """``J = 1 / (8 pi) int K_ij phi^i n^j dA``, a length squared, with ``phi = axis x (x - center)``.

        It means something where phi is a symmetry of the surface, or nearly so.  The axis is found by
        `isoembed.relativity.find_spin`.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats
            Of any length but zero.
        """
        a = np.array(_unit("the axis", axis))
        n, before = self.harmonics.degree + 8, np.inf
        while True:
            u, weights = gauss_rule(n, 2 * n)
            frame = self.frame(geometry, u)
            density = frame.torque() @ a * weights * area_density(frame.q) / (8.0 * np.pi)
            J, size = float(density.sum()), float(np.abs(density).sum())
            if abs(J - before) <= STAR.settled * size or n > STAR.highest_degree:
                return J
            n, before = 2 * n, J

    def data(
        self,
        geometry: ThreeGeometry,
        axis: Sequence[float] | None = None,
        marginal: bool = False,
        name: str = "",
    ) -> SurfaceData:
        """Data of which quasi-local energies are computed.

        Their errors are what the misfit makes, and what the geometry says of its own.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats, optional
            The axis that the angular momentum is asked about.  By default it is found: see
            `isoembed.relativity.find_spin`.
        marginal : bool
            The surface is a horizon: the mean curvature vector is null by definition.
        name : str
            For reports.

        Raises
        ------
        InvalidMetric
            The slice's metric is not positive definite, or its extrinsic curvature not finite, on the
            surface; the message names a point.
        """
        moves = not geometry.time_symmetric
        u, weights = gauss_rule(*STAR.nodes)
        frame = self.frame(geometry, u)
        errors = SurfaceErrors.of_surface(frame, self._deviating(geometry, u), weights)
        if self.deviations is None:
            miss = self.misfit / self.mean_radius
            errors = replace(errors, lengths=Uncertainty(miss, miss))
        errors += SurfaceErrors.of_slice(frame, weights)
        about = None if axis is None else _unit("the axis", axis)
        J = 0.0 if not moves else about and self.angular_momentum(geometry, about)

        def momentum(u: Floats) -> Floats:
            return self.momentum(geometry, u)

        def normal_momentum(u: Floats) -> Floats:
            return self.normal_momentum(geometry, u)

        def torque(u: Floats) -> Floats:
            return self.frame(geometry, u).torque()

        return SurfaceData(
            metric=InducedMetric(self, geometry, errors.lengths),
            mean_curvature=UncertainFunction(
                lambda u: self.mean_curvature(geometry, u), errors.mean_curvature
            ),
            momentum=UncertainFunction(momentum, errors.momentum) if moves else None,
            normal_momentum=UncertainFunction(normal_momentum, errors.normal_momentum) if moves else None,
            angular_momentum=J,
            marginal=marginal,
            shape=self.points,
            name=name,
            notes=self.notes,
            axis=about,
            torque=UncertainFunction(torque, errors.torque) if moves else None,
        )


@dataclass(frozen=True)
class InducedMetric:
    """The metric that a slice induces on a surface; a `isoembed.smooth.TwoMetric`.

    Attributes
    ----------
    surface : StarSurface
    geometry : ThreeGeometry
    error : Uncertainty
        Of lengths, relative.
    """

    surface: StarSurface
    geometry: ThreeGeometry
    error: Uncertainty = EXACT

    def tensor(self, u: Floats) -> Floats:
        """See `isoembed.smooth.TwoMetric`."""
        return self.surface.frame(self.geometry, u).q


def _unit(what: str, given: Sequence[float]) -> tuple[float, float, float]:
    """A vector of length one along a given one."""
    x = np.array(vector(what, given))
    if not x.any():
        raise InvalidParameter(f"{what} must not be zero")
    x /= np.abs(x).max()
    a, b, c = map(float, x / np.linalg.norm(x))
    return a, b, c


def _directions(u: ArrayLike) -> Floats:
    array = numbers(u)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidParameter(f"directions must be unit vectors (n, 3), not an array {array.shape}")
    return array


def _check_radius(u: Floats, r: Floats) -> None:
    good = np.isfinite(r) & (r > 0.0)
    if not good.all():
        i = int(np.argmin(good))
        raise InvalidParameter(
            f"the radius is {r[i]:.6g} in the direction {written(u[i])}: it must be positive"
        )


def _radii(radius: Callable[[Floats], ArrayLike], u: Floats) -> Floats:
    r = np.asarray(radius(u), dtype=np.float64)
    if r.shape != (len(u),):
        raise InvalidParameter(f"the radius has the shape {r.shape} for {len(u)} directions")
    _check_radius(u, r)
    return r
