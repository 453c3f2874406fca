"""Star-shaped surfaces in a 3-geometry: radius by direction in spherical harmonics, and what lies on them.

The derivatives are covariant ones along two tangent vectors at each direction: no point is singular.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.spacetimes.checks import check_slice, numbers, positive_number, vector, written
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.transforms import analyzed, fitted, trimmed
from isoembed.smooth.two_metric import area_density, orthonormal_frame, projected

Floats = NDArray[np.float64]

LARGEST_DEGREE = 128
"""Up to which degree the harmonics of a function are sought."""
ROUNDING = 1e-15
"""What is rounding in the harmonics of a radius, over the radius."""
MISSED = 1e-6
"""How far harmonics may miss a radius, over the radius; more is no smooth surface."""
CHECKED = (24, 48)
"""Nodes in theta and phi at which a slice tells its errors."""


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

    Raises
    ------
    InvalidParameter
        The radius is not positive; the message names a direction.
    """

    center: Sequence[float]
    harmonics: Harmonics
    coefficients: Floats
    misfit: float = 0.0

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
        """Return the coordinate sphere with this center and radius."""
        positive_number("the radius", radius)
        return cls(center, Harmonics(0, 0), np.array([radius * np.sqrt(4.0 * np.pi)]))

    @classmethod
    def from_radius(
        cls, radius: Callable[[Floats], ArrayLike], center: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> StarSurface:
        """Project a radius onto harmonics, up to the degree where only rounding or noise is left.

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
        apart = fibonacci_directions(200)
        expected = _radii(radius, apart)
        found: list[tuple[float, Harmonics, Floats, float]] = []
        degree = 16
        while degree <= LARGEST_DEGREE:
            u, weights = gauss_rule(degree + 1, 2 * degree + 2)
            coefficients, harmonics = analyzed(_radii(radius, u), u, weights, degree)
            sizes = np.abs(coefficients) / abs(coefficients[0])
            tail = float(sizes[harmonics.labels[0] > 3 * degree // 4].max())
            coefficients, harmonics = trimmed(coefficients, harmonics, sizes > ROUNDING / 4.0)
            error = (harmonics.values(apart) @ coefficients - expected) / expected.max()
            missed = float(np.abs(error).max())
            if missed <= MISSED:
                misfit = float(np.sqrt(np.mean(error**2)) * expected.max())
                found.append((missed, harmonics, coefficients, misfit))
                if tail <= ROUNDING and missed <= 1e3 * ROUNDING:
                    return cls(center, harmonics, coefficients, misfit)
            degree *= 2
        if not found:
            raise InvalidParameter(
                f"the radius is not smooth enough for harmonics: those of degree {LARGEST_DEGREE} are still "
                f"{tail:.3g} of the mean, and miss it by {missed:.3g}; fit points instead"
            )
        # Harmonics that come no nearer would be noise, and their second derivatives loud noise.
        enough = 2.0 * min(missed for missed, *_ in found)
        _, harmonics, coefficients, misfit = next(fit for fit in found if fit[0] <= enough)
        return cls(center, harmonics, coefficients, misfit)

    @classmethod
    def from_angles(
        cls, radius: Callable[[Floats, Floats], ArrayLike], center: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> StarSurface:
        """Project a radius that is given by angles onto harmonics; see `from_radius`.

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
    def from_points(cls, points: ArrayLike, center: Sequence[float]) -> StarSurface:
        """Fit harmonics to points by least squares, weighted by the solid angles for which the points stand.

        The degree is the one of least generalized cross-validation, at most 40; see
        `isoembed.smooth.transforms.fitted`.

        Parameters
        ----------
        points : array_like, shape (m, 3)
            One on each ray from the center; points given twice do no harm.
        center : three floats

        Raises
        ------
        InvalidParameter
            The points are too few, not finite, at the center, or do not surround it.
        """
        c = vector("the center", center)
        x = np.asarray(points, dtype=np.float64)
        if x.ndim != 2 or x.shape[1] != 3 or len(x) < 8:
            raise InvalidParameter(f"points must be an array (m, 3) with m >= 8, not {x.shape}")
        good = np.isfinite(x).all(axis=1)
        if not good.all():
            i = int(np.argmin(good))
            raise InvalidParameter(f"point {i} is {written(x[i])}: that is not finite")
        d = x - c
        r = np.linalg.norm(d, axis=1)
        if r.min() == 0.0:
            raise InvalidParameter(f"point {int(np.argmin(r))} is the center {written(np.array(c))} itself")
        u = d / r[:, None]
        weights = _solid_angles(u)
        used = weights > 0.0
        coefficients, harmonics, misfit = fitted(u[used], r[used], weights[used])
        return cls(c, harmonics, coefficients, misfit)

    def radius(self, u: Floats) -> Floats:
        """The radius (n,) in the directions u (n, 3)."""
        return self._derivatives(_directions(u))[0]

    def points(self, u: Floats) -> Floats:
        """The points X (n, 3) in the directions u (n, 3)."""
        u = _directions(u)
        return np.array(self.center) + self.radius(u)[:, None] * u

    def differential(self, u: Floats) -> Floats:
        """The differential dX (n, 3, 3): ``dX @ v`` is the derivative of X along a tangent vector v."""
        u = _directions(u)
        r, slope, _ = self._derivatives(u)
        return _differential(u, r, slope)

    def metric(self, geometry: ThreeGeometry) -> InducedMetric:
        """Return the metric that the geometry induces on the surface."""
        return InducedMetric(self, geometry)

    def mean_curvature(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) for the outward normal, in the directions u (n, 3); 2 / r on a flat sphere."""
        return self._frame(geometry, u).mean_curvature(geometry)

    def momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,) in the directions u (n, 3)."""
        return self._frame(geometry, u).momentum(geometry)

    def normal_momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``K(., n)`` as tangent vectors (n, 3) of the unit sphere at u (n, 3): see `SurfaceData`."""
        return self._frame(geometry, u).normal_momentum(geometry)

    def expansion(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``theta_+ = k - p`` (n,) of the light rays that leave outward; zero on an apparent horizon."""
        frame = self._frame(geometry, u)
        return frame.mean_curvature(geometry) - frame.momentum(geometry)

    def angular_momentum(self, geometry: ThreeGeometry, axis: Sequence[float]) -> float:
        """``J = 1 / (8 pi) int K_ij phi^i n^j dA``, a length squared, with ``phi = axis x (x - center)``.

        It means something where phi is a symmetry of the surface, or nearly so.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats
            Of any length but zero.
        """
        a = np.array(vector("the axis", axis))
        if not a.any():
            raise InvalidParameter("the axis must not be zero")
        a /= np.linalg.norm(a)
        n, before = self.harmonics.degree + 8, np.inf
        while True:
            u, weights = gauss_rule(n, 2 * n)
            f = self._frame(geometry, u)
            phi = np.cross(a, f.r[:, None] * u)
            density = np.einsum("ni,nij,nj->n", phi, _curvature(geometry, f.x), f.upper)
            density *= weights * area_density(f.q) / (8.0 * np.pi)
            J = float(density.sum())
            if abs(J - before) <= 1e-13 * float(np.abs(density).sum()) or n > LARGEST_DEGREE:
                return J
            n, before = 2 * n, J

    def data(
        self,
        geometry: ThreeGeometry,
        axis: Sequence[float] | None = None,
        marginal: bool = False,
        name: str = "",
    ) -> SurfaceData:
        """Return what quasi-local energies are computed from.

        Their ``relative_error`` is the misfit over the mean radius and what the geometry says of its own.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats, optional
            The axis of rotation for the angular momentum, which is left out without it.
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
        frame = self._frame(geometry, gauss_rule(*CHECKED)[0])
        frame.mean_curvature(geometry)
        if not geometry.time_symmetric:
            frame.momentum(geometry)
        mean = self.coefficients[0] / np.sqrt(4.0 * np.pi)
        return SurfaceData(
            metric=self.metric(geometry),
            mean_curvature=lambda u: self.mean_curvature(geometry, u),
            momentum=None if geometry.time_symmetric else lambda u: self.momentum(geometry, u),
            normal_momentum=None if geometry.time_symmetric else lambda u: self.normal_momentum(geometry, u),
            angular_momentum=None if axis is None else self.angular_momentum(geometry, axis),
            marginal=marginal,
            relative_error=float(self.misfit / mean) + geometry.relative_error(frame.x),
            name=name,
        )

    def _derivatives(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """The radius (n,), its gradient (n, 3) and its covariant second derivatives (n, 3, 3)."""
        return self.harmonics.derivatives(u, self.coefficients)

    def _frame(self, geometry: ThreeGeometry, u: Floats) -> _Frame:
        u = _directions(u)
        r, slope, hessian = self._derivatives(u)
        x = np.array(self.center) + r[:, None] * u
        gamma = _slice_metric(geometry, x)
        dX = _differential(u, r, slope)
        q = projected(dX.transpose(0, 2, 1) @ gamma @ dX, u)
        e = orthonormal_frame(u, q)
        T = e @ dX.transpose(0, 2, 1)
        lower = np.cross(T[:, 0], T[:, 1])
        upper = np.linalg.solve(gamma, lower[:, :, None])[:, :, 0]
        length = np.sqrt(np.einsum("ni,ni->n", lower, upper))[:, None]
        tangent = T.transpose(0, 2, 1) @ T
        return _Frame(u, r, slope, hessian, x, q, e, tangent, lower / length, upper / length)


@dataclass(frozen=True)
class InducedMetric:
    """The metric that a slice induces on a surface; a `isoembed.smooth.TwoMetric`.

    Attributes
    ----------
    surface : StarSurface
    geometry : ThreeGeometry
    """

    surface: StarSurface
    geometry: ThreeGeometry

    def tensor(self, u: Floats) -> Floats:
        """See `isoembed.smooth.TwoMetric`."""
        u = _directions(u)
        r, slope, _ = self.surface._derivatives(u)
        gamma = _slice_metric(self.geometry, np.array(self.surface.center) + r[:, None] * u)
        dX = _differential(u, r, slope)
        return projected(dX.transpose(0, 2, 1) @ gamma @ dX, u)


@dataclass(frozen=True)
class _Frame:
    """The surface to second order, at n directions."""

    u: Floats
    """The directions (n, 3)."""
    r: Floats
    """The radius (n,)."""
    slope: Floats
    """Its gradient on the unit sphere (n, 3)."""
    hessian: Floats
    """Its covariant second derivatives there (n, 3, 3)."""
    x: Floats
    """The points (n, 3)."""
    q: Floats
    """The metric (n, 3, 3)."""
    e: Floats
    """Two tangent vectors of the unit sphere (n, 2, 3), orthonormal for q."""
    tangent: Floats
    """``gamma^ij - n^i n^j`` (n, 3, 3)."""
    lower: Floats
    """``n_i`` (n, 3)."""
    upper: Floats
    """``n^i`` (n, 3)."""

    def mean_curvature(self, geometry: ThreeGeometry) -> Floats:
        """See `StarSurface`.

        k is the trace of ``h_AB = -n_i (D_A D_B X^i + Gamma^i_jk X^j_A X^k_B)``, D the derivative of the
        unit sphere: another one would change the first term by a tangent vector.
        """
        inverse = self.e.transpose(0, 2, 1) @ self.e  # of q
        bent = np.einsum("nij,nij->n", inverse, self.hessian) - self.r * np.einsum("nii->n", inverse)
        turned = np.einsum("nij,nj->ni", inverse, self.slope)
        flat = np.einsum("ni,ni->n", self.lower, bent[:, None] * self.u + 2.0 * turned)
        gradient = _finite("the gradient of the 3-metric", geometry.gradient(self.x), self.x)
        along = np.einsum("nkj,nkji->ni", self.tangent, gradient)
        across = np.einsum("nijk,njk->ni", gradient, self.tangent)
        return -flat - np.einsum("ni,ni->n", self.upper, along - 0.5 * across)

    def momentum(self, geometry: ThreeGeometry) -> Floats:
        """See `StarSurface`."""
        return np.einsum("nij,nij->n", self.tangent, _curvature(geometry, self.x))

    def normal_momentum(self, geometry: ThreeGeometry) -> Floats:
        """See `StarSurface`."""
        toward = np.einsum("nij,nj->ni", _curvature(geometry, self.x), self.upper)
        pulled = np.einsum("nki,nk->ni", _differential(self.u, self.r, self.slope), toward)
        return pulled - np.einsum("ni,ni->n", pulled, self.u)[:, None] * self.u


def _directions(u: ArrayLike) -> Floats:
    array = numbers(u)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidParameter(f"directions must be unit vectors (n, 3), not an array {array.shape}")
    return array


def _differential(u: Floats, r: Floats, slope: Floats) -> Floats:
    return u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)


def _slice_metric(geometry: ThreeGeometry, x: Floats) -> Floats:
    gamma = geometry.metric(x)
    check_slice("the 3-metric", x, gamma)
    return gamma


def _finite(what: str, values: Floats, x: Floats) -> Floats:
    good = np.isfinite(values.reshape(len(x), -1)).all(axis=1)
    if not good.all():
        raise InvalidMetric(f"{what} at {written(x[int(np.argmin(good))])} is not finite")
    return values


def _curvature(geometry: ThreeGeometry, x: Floats) -> Floats:
    """``K_ij`` (n, 3, 3)."""
    return _finite("the extrinsic curvature", geometry.extrinsic_curvature(x), x)


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


def _solid_angles(u: Floats) -> Floats:
    """A third of the spherical triangles of the convex hull at each direction; zero for one given twice.

    Raises
    ------
    InvalidParameter
        The directions leave a half-space empty.
    """
    apart = "the points do not surround the center: a half-space has none"
    try:
        hull = ConvexHull(u)
    except QhullError:
        raise InvalidParameter(apart) from None
    if hull.equations[:, 3].max() >= 0.0:
        raise InvalidParameter(apart)
    a, b, c = u[hull.simplices].transpose(1, 0, 2)
    dot = 1.0 + np.einsum("ni,ni->n", a, b) + np.einsum("ni,ni->n", b, c) + np.einsum("ni,ni->n", c, a)
    solid = 2.0 * np.arctan2(np.abs(np.einsum("ni,ni->n", a, np.cross(b, c))), dot)
    weights = np.zeros(len(u))
    np.add.at(weights, hull.simplices, solid[:, None] / 3.0)
    return weights
