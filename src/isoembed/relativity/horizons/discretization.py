"""Discretization of a surface family in spherical harmonics, and its linearized equations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from isoembed.arrays import Floats, Indices
from isoembed.relativity.horizons.expansion_operator import LinearizedExpansion, linearized
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform

DEALIASING = 1.5  # circles of nodes over the degree: products are not aliased


@dataclass(frozen=True, eq=False)
class Iterate:
    """One surface of a family: the coefficients (size,) of f, and its local geometry at the nodes."""

    f: Floats
    local: LocalGeometry

    @property
    def radius(self) -> float:
        """The mean distance from the mean point, root-mean-square over the nodes."""
        x = self.local.jet.x
        return float(np.sqrt(np.mean(np.sum((x - x.mean(axis=0)) ** 2, axis=1))))


@dataclass(frozen=True, eq=False)
class Discretization:
    """Surfaces of a family in harmonics of one degree, in a slice.

    Attributes
    ----------
    geometry : ThreeGeometry
    transform : SphereTransform
    family : SurfaceFamily
        At the nodes of the transform.
    """

    geometry: ThreeGeometry
    transform: SphereTransform
    family: SurfaceFamily

    def iterate(self, f: Floats) -> Iterate:
        """The surface with the coefficients f (size,).

        Raises `InvalidMetric` or `InvalidParameter`: it leaves the points where the slice is known.
        """
        c, T = f[:, None], self.transform
        surface = self.family.at(T.values(c)[:, 0], T.gradients(c)[:, :, 0], T.hessians(c)[:, :, 0])
        local = LocalGeometry.of(self.geometry, surface)
        _ = local.expansion  # refuses points where the slice is not known
        return Iterate(f, local)

    def expansion_errors(self, at: Iterate) -> Floats:
        """Errors (n,) of the expansion, as the slice tells them."""

        def expansion(geometry: ThreeGeometry) -> Floats:
            return LocalGeometry.of(geometry, at.local.jet).expansion[None]

        return self.geometry.error(expansion)[0]

    def areal_radius(self, at: Iterate) -> float:
        """The root of the area over 4 pi."""
        return float(np.sqrt(self.transform.weights @ at.local.density / (4.0 * np.pi)))

    def equations(self, at: Iterate) -> Equations:
        """Equations for changes of f that change the expansion as asked for."""
        return Equations(self.transform, LowDegrees.of(self.transform), linearized(self.family, at.local))


@dataclass(frozen=True, eq=False)
class LowDegrees:
    """Harmonics of low degrees at the nodes, with their derivatives: (N, s), (N, 2, s) and (N, 3, s).

    ``place`` (s,) says which they are among all.
    """

    values: Floats
    slopes: Floats
    hessians: Floats
    place: Indices

    @staticmethod
    @lru_cache(maxsize=1)
    def of(transform: SphereTransform) -> LowDegrees:
        """All harmonics of a transform if they are few, and otherwise those of low degree."""
        T, harmonics = transform, transform.harmonics
        # Up to so many harmonics, with symmetry about the z-axis more, equations are solved directly.
        if harmonics.size > (300, 1100)[int(harmonics.order == 0)]:
            degree = 8  # of the harmonics whose equations are the preconditioner
            T = SphereTransform(Harmonics(degree, min(degree, harmonics.order)), T.n, T.around)
        places = {label: i for i, label in enumerate(zip(*harmonics.labels, strict=True))}
        place = np.array([places[label] for label in zip(*T.harmonics.labels, strict=True)])
        one = np.eye(T.harmonics.size)
        return LowDegrees(T.values(one), T.gradients(one), T.hessians(one), place)


@dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations: that the change of the expansion has a given projection on the harmonics.

    Attributes
    ----------
    transform : SphereTransform
    low : LowDegrees
    linear : LinearizedExpansion
    shift : float
        What is subtracted from the stability operator; see `isoembed.relativity.horizons.stability`.
    free : bool
        The mean of f is held, and the expansion may change by a constant instead, which takes its place.
    """

    transform: SphereTransform
    low: LowDegrees
    linear: LinearizedExpansion
    shift: float = 0.0
    free: bool = False

    def projected(self, theta: Floats) -> Floats:
        """The projection (size, c) of changes of the expansion (N, c)."""
        weights = self.transform.weights * self.linear.scale
        return self.transform.adjoint_values(weights[:, None] * theta)

    def applied(self, f: Floats) -> Floats:
        """The projection (size,) for unknowns f (size,)."""
        T = self.transform
        c = f[:, None].copy()
        if self.free:
            c[0] = 0.0
        theta = self._changed(T.values(c), T.gradients(c), T.hessians(c))
        if self.free:
            theta -= f[0]
        return self.projected(theta)[:, 0]

    def solved(self, right: Floats) -> Floats:
        """The unknowns (size,) whose projection is given, as well as it goes."""
        if len(self.low.place) == self.transform.harmonics.size:
            return np.asarray(lu_solve(self._factors, right))
        size = len(right)
        found, _ = gmres(
            LinearOperator((size, size), self.applied),
            right,
            rtol=1e-8,  # enough for Newton's method
            restart=100,  # iterations without a restart
            maxiter=1,
            M=LinearOperator((size, size), self._preconditioned),
        )
        return np.asarray(found)

    def matrix(self) -> Floats:
        """Matrix of the low degrees (s, s)."""
        low = self.low
        theta = self._changed(low.values, low.slopes, low.hessians)
        if self.free:
            theta[:, 0] = -1.0
        theta *= (self.linear.scale * self.transform.weights)[:, None]
        return np.asarray(low.values.T @ theta)

    def _changed(self, values: Floats, slopes: Floats, hessians: Floats) -> Floats:
        theta = self.linear.applied(values, slopes, hessians)
        if self.shift:
            theta -= (self.shift * self.linear.tilt)[:, None] * values
        return theta

    @cached_property
    def _factors(self) -> tuple[Floats, Indices]:
        return lu_factor(self.matrix())

    @cached_property
    def _diagonal(self) -> Floats:
        """Diagonal of the equations, as if the surface were a round sphere."""
        degrees = self.transform.harmonics.labels[0]
        mean = self.transform.weights @ (self.linear.scale * self.linear.zeroth) / (4.0 * np.pi)
        laplacian = degrees * (degrees + 1.0)
        return np.maximum(laplacian + mean, 0.5 * laplacian + 1.0)

    def _preconditioned(self, right: Floats) -> Floats:
        out = right / self._diagonal
        out[self.low.place] = lu_solve(self._factors, right[self.low.place])
        return out
