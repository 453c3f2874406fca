"""Star-shaped surfaces in a slice, with the radius in spherical harmonics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.checks import positive_number, vector, written
from isoembed.relativity.spacetimes.jet import Jet, SurfaceFamily, in_angle_frame
from isoembed.relativity.spacetimes.point_cloud import checked_points, seen_from
from isoembed.relativity.spacetimes.surface import ON_SURFACE, Surface, as_directions
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry, check_geometry
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.projection import project
from isoembed.smooth.scattered_fit import deviating, fitted, white
from isoembed.smooth.user_functions import real_values
from isoembed.surface.estimate import percent


@short_repr
@dataclass(frozen=True, eq=False)
class StarSurface(Surface):
    """Star-shaped surface ``X(u) = center + r(u) u`` over unit vectors u.

    Attributes
    ----------
    center : three floats
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size,)
        Coefficients of r, lengths.
    misfit : float
        Root-mean-square difference of r from the given function at other directions, or from the points.
    deviations : ndarray, shape (N, size), optional
        Random samples of the error of the coefficients of a fit to points, in the harmonics of
        `isoembed.smooth.scattered_fit.deviating`; by default noise of the size of the misfit.
    notes : tuple of str
        Notes on omitted points, for reports.

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
                f"{self.harmonics.size} harmonics require as many coefficients, not {coefficients.shape}"
            )
        coefficients.setflags(write=False)
        object.__setattr__(self, "coefficients", coefficients)
        u, _ = gauss_rule(self.harmonics.degree + 2, 2 * self.harmonics.order + 2)
        _check_radius(u, self.radius(u))

    @classmethod
    def sphere(cls, center: Sequence[float], radius: float) -> StarSurface:
        """Coordinate sphere with a given center and radius."""
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
            Smooth function that takes unit vectors u (n, 3) and returns r (n,).
        center : three floats

        Raises
        ------
        InvalidParameter
            A radius is not positive, or the relative error exceeds 1e-6 with harmonics up to degree 128; the
            message says which.

        Notes
        -----
        The truncation error, if larger than rounding, is the ``misfit``.
        """
        if not callable(radius):
            raise InvalidParameter(
                f"the radius is a {type(radius).__name__}, not a function of unit vectors u (n, 3); values r "
                "in some directions u are for from_points(center + r u, center), and a number is for sphere"
            )
        fit = project(lambda u: _radii(radius, u)[:, None], "the radius")
        return cls(center, fit.harmonics, fit.coefficients[:, 0], fit.misfit)

    @classmethod
    def from_angles(
        cls, radius: Callable[[Floats, Floats], ArrayLike], center: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> StarSurface:
        """Projection of a radius given as a function of angles; see `from_radius`.

        Parameters
        ----------
        radius : callable
            Takes arrays theta and phi, in (0, pi) and [0, 2 pi), and returns r.  It is never called at the
            poles.
        center : three floats
        """

        def by_direction(u: Floats) -> ArrayLike:
            theta = np.arctan2(np.hypot(u[:, 0], u[:, 1]), u[:, 2])
            phi = np.arctan2(u[:, 1], u[:, 0]) % (2.0 * np.pi)
            return np.broadcast_to(
                real_values("the function for the radius", radius, theta, phi), theta.shape
            )

        return cls.from_radius(by_direction, center)

    @classmethod
    def from_points(
        cls, points: ArrayLike, center: Sequence[float], faces: Indices | None = None
    ) -> StarSurface:
        """Least-squares fit of harmonics to points, weighted by their solid angles.

        The degree, at most 40, is chosen by generalized cross-validation.  Isolated outliers are omitted and
        named in the ``notes``; see `isoembed.smooth.scattered_fit.fitted`.

        Parameters
        ----------
        points : array_like, shape (m, 3)
            Points, one on each ray from the center; duplicates are allowed.
        center : three floats
        faces : ndarray of int, shape (F, 3), optional
            Convex hull of the directions from the center, if already computed.

        Raises
        ------
        InvalidParameter
            There are too few points, one is not finite or at the center, or they do not surround it.
        """
        c = vector("the center", center)
        x = checked_points(points)
        u, r, weights = seen_from(x, np.array(c), faces)
        used = weights > 0.0
        fit = fitted(u[used], r[used], weights[used])
        notes = tuple(
            f"point {i} at {written(x[i])} was left out: it lies {abs(apart):.3g} "
            f"{'outside' if apart > 0.0 else 'inside'} the surface that fits the others "
            f"({percent(abs(apart) / r[i])} of its radius)"
            for i, apart in zip(np.flatnonzero(used)[fit.left_out], fit.apart, strict=True)
        )
        return cls(c, fit.harmonics, fit.coefficients, fit.misfit, fit.deviations, notes)

    @property
    def mean_radius(self) -> float:
        """Mean of the radius over all directions."""
        return float(self.coefficients[0] / np.sqrt(4.0 * np.pi))

    def radius(self, u: Floats) -> Floats:
        """Radius (n,) in the directions u (n, 3)."""
        return self.harmonics.derivatives(as_directions(u), self.coefficients)[0]

    def data(
        self,
        geometry: ThreeGeometry,
        axis: Sequence[float] | None = None,
        marginal: bool = False,
        name: str = "",
    ) -> SurfaceData:
        """See `Surface.data`.

        Raises
        ------
        InvalidMetric
            See `Surface.data`.
        InvalidParameter
            The surface passes through a black hole of the slice.
        """
        check_geometry(geometry)
        for _, position in geometry.black_holes:
            away = np.subtract(position, self.center)
            distance = float(np.linalg.norm(away))
            if distance > 0.0:
                (r,) = self.radius(away[None] / distance)
                if abs(r - distance) <= ON_SURFACE * distance:
                    raise InvalidParameter(
                        f"the surface passes through the black hole at {written(np.array(position))}"
                    )
        return super().data(geometry, axis, marginal, name)

    def jet(self, u: Floats) -> Jet:
        """See `Surface`."""
        return self._jet(u, *self.harmonics.derivatives(u, self.coefficients))

    def deviating(self, u: Floats) -> Iterator[Jet]:
        """See `Surface`."""
        r, slope, hessian = self.harmonics.derivatives(u, self.coefficients)
        harmonics = deviating(self.harmonics)
        drawn = white(self.harmonics, self.misfit) if self.deviations is None else self.deviations
        for deviation in drawn:
            dr, d_slope, d_hessian = harmonics.derivatives(u, deviation)
            yield self._jet(u, r + dr, slope + d_slope, hessian + d_hessian)

    def _jet(self, u: Floats, r: Floats, gradient: Floats, hessian: Floats) -> Jet:
        slopes, bends = in_angle_frame(u, gradient[:, None], hessian[:, None])
        return SurfaceFamily.star(self.center, u).at(r, slopes[:, :, 0], bends[:, :, 0])


def _check_radius(u: Floats, r: Floats) -> None:
    good = np.isfinite(r) & (r > 0.0)
    if not good.all():
        i = int(np.argmin(good))
        raise InvalidParameter(
            f"the radius is {r[i]:.6g} in the direction {written(u[i])}: it must be positive"
        )


def _radii(radius: Callable[[Floats], ArrayLike], u: Floats) -> Floats:
    r = real_values("the function for the radius", radius, u)
    if r.shape != (len(u),):
        raise InvalidParameter(f"the radius has the shape {r.shape} for {len(u)} directions")
    _check_radius(u, r)
    return r
