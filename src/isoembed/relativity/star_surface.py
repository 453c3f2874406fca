"""Star-shaped surfaces in a 3-geometry: radius by direction in spherical harmonics, and what lies on them.

The derivatives are covariant ones along two tangent vectors at each direction: no point is singular.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr, solve_triangular, svdvals
from scipy.spatial import ConvexHull, QhullError

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.surface_data import SurfaceData
from isoembed.relativity.three_geometry import ThreeGeometry, check_slice, positive_number, vector, written
from isoembed.smooth.harmonics import Harmonics, gauss_rule
from isoembed.smooth.two_metric import PulledBack, area_density, orthonormal_frame, projected

Floats = NDArray[np.float64]

LARGEST_DEGREE = 128
"""Up to which degree the harmonics of a function are sought."""
LARGEST_FITTED = 40
"""Up to which degree harmonics are fitted to points."""
ROUNDING = 1e-15
"""What is rounding in the harmonics of a radius, over the radius."""


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
        """Project a radius onto harmonics, up to the degree where only rounding is left.

        Parameters
        ----------
        radius : callable
            Takes unit vectors u (n, 3) and returns r (n,); smooth.
        center : three floats

        Raises
        ------
        InvalidParameter
            A radius is not positive, or harmonics up to degree 128 leave a rest; the message says which.
        """
        apart = _spread_directions(200)
        expected = _radii(radius, apart)
        degree = 16
        while True:
            u, weights = gauss_rule(degree + 1, 2 * degree + 2)
            harmonics, coefficients = _projected(_radii(radius, u), u, weights, degree)
            sizes = np.abs(coefficients) / abs(coefficients[0])
            tail = float(sizes[harmonics.labels[0] > 3 * degree // 4].max())
            harmonics, coefficients = _trimmed(harmonics, coefficients, sizes > ROUNDING / 4.0)
            error = (harmonics.values(apart) @ coefficients - expected) / expected.max()
            if tail <= ROUNDING and np.abs(error).max() <= 1e3 * ROUNDING:
                misfit = float(np.sqrt(np.mean(error**2)) * expected.max())
                return cls(center, harmonics, coefficients, misfit)
            if degree >= LARGEST_DEGREE:
                raise InvalidParameter(
                    f"the radius is not smooth enough for harmonics: those of degree {degree} are still "
                    f"{tail:.3g} of the mean, and miss it by {np.abs(error).max():.3g}; fit points instead"
                )
            degree *= 2

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

        The degree is the one of least generalized cross-validation, at most 40: what follows is noise.  It is
        lowered where holes between the points would leave coefficients undetermined.

        Parameters
        ----------
        points : array_like, shape (m, 3)
            One on each ray from the center; points given twice do no harm.
        center : three floats

        Raises
        ------
        InvalidParameter
            The points are too few, not finite, at the center, or do not surround it.

        References
        ----------
        Golub, Heath and Wahba, Technometrics 21 (1979) 215.
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
        return cls(c, *_fitted(u[used], r[used], weights[used]))

    def radius(self, u: Floats) -> Floats:
        """The radius (n,) in the directions u (n, 3)."""
        return self._in_parts(u, lambda part: self.harmonics.values(part) @ self.coefficients)

    def points(self, u: Floats) -> Floats:
        """The points X (n, 3) in the directions u (n, 3)."""
        return np.array(self.center) + self.radius(u)[:, None] * u

    def differential(self, u: Floats) -> Floats:
        """The differential dX (n, 3, 3): ``dX @ v`` is the derivative of X along a tangent vector v."""
        return u[:, :, None] * self._slope(u)[:, None, :] + self.radius(u)[:, None, None] * np.eye(3)

    def metric(self, geometry: ThreeGeometry) -> PulledBack:
        """Return the metric that the geometry induces on the surface."""
        return PulledBack(self.differential, lambda u: _slice_metric(geometry, self.points(u)))

    def mean_curvature(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) for the outward normal, in the directions u (n, 3); 2 / r on a flat sphere.

        k is the trace of ``h_AB = -n_i (D_A D_B X^i + Gamma^i_jk X^j_A X^k_B)``, D the derivative of the unit
        sphere: another one would change the first term by a tangent vector.
        """
        f = self._frame(geometry, u)
        hessian = self.harmonics.second_along(u, f.e, self.coefficients[:, None])[..., 0]
        bent = np.einsum("naa->n", hessian) - f.r * np.einsum("nai,nai->n", f.e, f.e)
        turned = np.einsum("nai,ni,naj->nj", f.e, f.slope, f.e)
        flat = np.einsum("ni,ni->n", f.lower, bent[:, None] * u + 2.0 * turned)
        gradient = geometry.gradient(f.x)
        along = np.einsum("nkj,nkji->ni", f.tangent, gradient)
        across = np.einsum("nijk,njk->ni", gradient, f.tangent)
        return -flat - np.einsum("ni,ni->n", f.upper, along - 0.5 * across)

    def momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,) in the directions u (n, 3)."""
        f = self._frame(geometry, u)
        return np.einsum("nij,nij->n", f.tangent, _curvature(geometry, f.x))

    def expansion(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``theta_+ = k - p`` (n,) of the light rays that leave outward; zero on an apparent horizon."""
        return self.mean_curvature(geometry, u) - self.momentum(geometry, u)

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

    def data(self, geometry: ThreeGeometry, axis: Sequence[float] | None = None) -> SurfaceData:
        """Return what quasi-local energies are computed from.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats, optional
            The axis of rotation for the angular momentum, which is left out without it.
        """
        return SurfaceData(
            metric=self.metric(geometry),
            mean_curvature=lambda u: self.mean_curvature(geometry, u),
            momentum=None if geometry.time_symmetric else lambda u: self.momentum(geometry, u),
            angular_momentum=None if axis is None else self.angular_momentum(geometry, axis),
        )

    def _slope(self, u: Floats) -> Floats:
        """The gradient of r on the unit sphere (n, 3)."""
        return self._in_parts(u, lambda part: self.harmonics.gradients(part)[1] @ self.coefficients)

    def _in_parts(self, u: Floats, f: Callable[[Floats], Floats]) -> Floats:
        size = max(1, 1_000_000 // self.harmonics.size)
        return np.concatenate([f(u[begin : begin + size]) for begin in range(0, max(len(u), 1), size)])

    def _frame(self, geometry: ThreeGeometry, u: Floats) -> _Frame:
        r, slope = self.radius(u), self._slope(u)
        x = np.array(self.center) + r[:, None] * u
        gamma = _slice_metric(geometry, x)
        dX = u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)
        q = projected(np.einsum("nki,nkl,nlj->nij", dX, gamma, dX), u)
        e = orthonormal_frame(u, q)
        T = np.einsum("nki,nai->nak", dX, e)
        lower = np.cross(T[:, 0], T[:, 1])
        upper = np.linalg.solve(gamma, lower[:, :, None])[:, :, 0]
        length = np.sqrt(np.einsum("ni,ni->n", lower, upper))[:, None]
        return _Frame(r, slope, x, q, e, np.einsum("nai,naj->nij", T, T), lower / length, upper / length)


@dataclass(frozen=True)
class _Frame:
    """The surface to first order, at n directions."""

    r: Floats
    """The radius (n,)."""
    slope: Floats
    """Its gradient on the unit sphere (n, 3)."""
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


def _slice_metric(geometry: ThreeGeometry, x: Floats) -> Floats:
    gamma = geometry.metric(x)
    check_slice("the 3-metric", x, gamma)
    return gamma


def _curvature(geometry: ThreeGeometry, x: Floats) -> Floats:
    """``K_ij`` (n, 3, 3), finite."""
    K = geometry.extrinsic_curvature(x)
    good = np.isfinite(K).all(axis=(1, 2))
    if not good.all():
        raise InvalidMetric(f"the extrinsic curvature at {written(x[int(np.argmin(good))])} is not finite")
    return K


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


def _spread_directions(n: int) -> Floats:
    """Directions (n, 3) on a spiral, in no step with a product rule."""
    i = np.arange(n)
    z, phi = 1.0 - (2.0 * i + 1.0) / n, np.pi * (3.0 - np.sqrt(5.0)) * i
    sin = np.sqrt(1.0 - z * z)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), z], axis=1)


def _projected(r: Floats, u: Floats, weights: Floats, degree: int) -> tuple[Harmonics, Floats]:
    """The harmonics of r on a Gauss rule of degree + 1 circles: Fourier on each, then Legendre."""
    harmonics = Harmonics(degree, degree)
    around = len(r) // (degree + 1)
    z, w = u[::around, 2], weights[::around, None] * (0.5 * around)
    meridian = np.stack([np.sqrt((1.0 - z) * (1.0 + z)), np.zeros_like(z), z], axis=1)
    values = harmonics.values(meridian)
    fourier = np.fft.rfft(r.reshape(-1, around), axis=1) * (2.0 / around)
    fourier[:, 0] *= 0.5
    coefficients = np.empty(harmonics.size)
    _, orders = harmonics.labels
    for m in range(degree + 1):
        P, f = values[:, orders == m], fourier[:, m : m + 1]
        projection = (w if m else 2.0 * w) * P
        c = projection.T @ f
        c += projection.T @ (f - P @ c)  # the weights of long rules have lost two digits
        coefficients[orders == m] = c[:, 0].real
        if m:
            coefficients[orders == -m] = -c[:, 0].imag
    return harmonics, coefficients


def _trimmed(
    harmonics: Harmonics, coefficients: Floats, needed: NDArray[np.bool_]
) -> tuple[Harmonics, Floats]:
    """The lowest degree and order that hold all coefficients that are needed."""
    degrees, orders = harmonics.labels
    fewer = Harmonics(int(degrees[needed].max()), int(np.abs(orders[needed]).max()))
    kept = (degrees <= fewer.degree) & (np.abs(orders) <= fewer.order)
    return fewer, coefficients[kept]


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


def _fitted(u: Floats, r: Floats, weights: Floats) -> tuple[Harmonics, Floats, float]:
    """Harmonics, their coefficients and the misfit, a length; see `StarSurface.from_points`."""
    m = len(u)
    most = max(0, min(LARGEST_FITTED, int(np.sqrt(0.5 * m)) - 1))
    highest = min(most, 8)
    root = np.sqrt(weights)
    while True:
        harmonics = Harmonics(highest, highest)
        sorted_by_degree = np.argsort(harmonics.labels[0], kind="stable")
        # One factorization serves all degrees: those of lower degree are its leading columns, and the data
        # as the last column become their components along them and, at the end, what is orthogonal to all.
        table = root[:, None] * np.column_stack([harmonics.values(u)[:, sorted_by_degree], r])
        (R,) = qr(table, mode="r", overwrite_a=True)
        b, left = R[: harmonics.size, -1], R[harmonics.size, -1] ** 2
        sizes = (np.arange(highest + 1) + 1) ** 2
        squares = left + np.concatenate([np.cumsum(b[::-1] ** 2)[::-1], [0.0]])[sizes]
        validation = squares / (1.0 - sizes / m) ** 2
        # As good as the least of all, but for chance.
        degree = int(np.argmax(validation <= (1.0 + np.sqrt(8.0 / m)) * validation.min()))
        if highest == most or degree <= 3 * highest // 4:
            break
        highest = min(2 * highest, most)

    def undetermined(l: int) -> bool:
        values = svdvals(R[: sizes[l], : sizes[l]])
        return bool(values[-1] < 0.1 * values[0])

    degree = bisect_left(range(degree + 1), True, key=undetermined) - 1  # the highest that is determined
    size = sizes[degree]
    chosen = Harmonics(degree, degree)
    coefficients = np.empty(size)
    coefficients[np.argsort(chosen.labels[0], kind="stable")] = solve_triangular(R[:size, :size], b[:size])
    return chosen, coefficients, float(np.sqrt(squares[degree] / weights.sum()))
