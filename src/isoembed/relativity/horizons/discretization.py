"""Discretization of a surface family in spherical harmonics, and its linearized equations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from isoembed.arrays import Floats, Indices
from isoembed.relativity.horizons.expansion_operator import LinearizedExpansion, extent, linearized
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform

DEALIASING = 1.5  # ratio of the number of latitude circles to the degree, which avoids aliasing of products


@dataclass(frozen=True, eq=False)
class Iterate:
    """Surface of a family: the coefficients (size,) of f and the local geometry at the nodes."""

    f: Floats
    local: LocalGeometry

    @property
    def radius(self) -> float:
        """Root-mean-square distance of the nodes from their mean."""
        return extent(self.local.jet.x)


@dataclass(frozen=True, eq=False)
class Discretization:
    """Surfaces of a family in a slice, in harmonics of a fixed degree.

    Attributes
    ----------
    geometry : ThreeGeometry
    transform : SphereTransform
    family : SurfaceFamily
        Family, evaluated at the nodes of the transform.
    """

    geometry: ThreeGeometry
    transform: SphereTransform
    family: SurfaceFamily

    def iterate(self, f: Floats) -> Iterate:
        """Surface with coefficients f (size,).

        Raises `InvalidMetric` or `InvalidParameter`: the surface leaves the domain of the slice.
        """
        local = LocalGeometry.of(self.geometry, self.family.at_nodes(self.transform, f))
        _ = local.expansion  # raises at points outside the domain of the slice
        return Iterate(f, local)

    def expansion_errors(self, at: Iterate) -> Floats:
        """Errors (n,) of the expansion, as estimated by the slice."""

        def expansion(geometry: ThreeGeometry) -> Floats:
            local = at.local if geometry is self.geometry else LocalGeometry.of(geometry, at.local.jet)
            return local.expansion[None]

        return self.geometry.error(expansion)[0]

    def areal_radius(self, at: Iterate) -> float:
        """Areal radius, ``sqrt(area / 4 pi)``."""
        return float(np.sqrt(self.transform.weights @ at.local.density / (4.0 * np.pi)))

    def equations(self, at: Iterate) -> Equations:
        """Linear equations for the change of f that produces a given change of the expansion."""
        return Equations(self.transform, LowDegrees.of(self.transform), linearized(self.family, at.local))


@dataclass(frozen=True, eq=False)
class LowDegrees:
    """Harmonics of low degree and their derivatives at the nodes: (N, s), (N, 2, s) and (N, 3, s).

    ``place`` (s,) has their indices among all harmonics.
    """

    values: Floats
    slopes: Floats
    hessians: Floats
    place: Indices

    @staticmethod
    @lru_cache(maxsize=1)
    def of(transform: SphereTransform) -> LowDegrees:
        """All harmonics of a transform if they are few, otherwise those of low degree."""
        T, harmonics = transform, transform.harmonics
        # Largest numbers of harmonics for a direct solution, without and with symmetry about the z-axis.
        if harmonics.size > (300, 1100)[int(harmonics.order == 0)]:
            degree = 8  # degree of the preconditioner's harmonics
            T = SphereTransform(Harmonics(degree, min(degree, harmonics.order)), T.n, T.around)
        places = {label: i for i, label in enumerate(zip(*harmonics.labels, strict=True))}
        place = np.array([places[label] for label in zip(*T.harmonics.labels, strict=True)])
        one = np.eye(T.harmonics.size)
        return LowDegrees(T.values(one), T.gradients(one), T.hessians(one), place)


@dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations for the projection of the change of the expansion onto the harmonics.

    Attributes
    ----------
    transform : SphereTransform
    low : LowDegrees
    linear : LinearizedExpansion
    shift : float
        Number subtracted from the stability operator; see
        `isoembed.relativity.horizons.principal_eigenvalue`.
    free : bool
        Whether the mean of f is fixed; the first unknown is then a constant change of the expansion.
    """

    transform: SphereTransform
    low: LowDegrees
    linear: LinearizedExpansion
    shift: float = 0.0
    free: bool = False

    def projected(self, theta: Floats) -> Floats:
        """Projection (size,) of a change of the expansion (N,)."""
        weights = self.transform.weights * self.linear.scale
        return self.transform.adjoint_values((weights * theta)[:, None])[:, 0]

    def applied(self, f: Floats) -> Floats:
        """Projection (size,) for unknowns f (size,)."""
        T = self.transform
        c = f[:, None].copy()
        if self.free:
            c[0] = 0.0
        theta = self._changed(T.values(c), T.gradients(c), T.hessians(c))[:, 0]
        if self.free:
            theta -= f[0]
        return self.projected(theta)

    def solved(self, right: Floats) -> Floats:
        """Solution (size,) of the equations, direct or by preconditioned GMRES without restart."""
        if len(self.low.place) == self.transform.harmonics.size:
            return np.asarray(lu_solve(self._factors, right))
        size = len(right)
        found, _ = gmres(
            LinearOperator((size, size), self.applied),
            right,
            rtol=1e-8,  # sufficient for Newton's method
            restart=100,  # largest number of iterations, as there is no restart
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
        """Approximate diagonal of the equations, exact for a round sphere."""
        degrees = self.transform.harmonics.labels[0]
        mean = self.transform.weights @ (self.linear.scale * self.linear.zeroth) / (4.0 * np.pi)
        laplacian = degrees * (degrees + 1.0)
        return np.maximum(laplacian + mean, 0.5 * laplacian + 1.0)

    def _preconditioned(self, right: Floats) -> Floats:
        out = right / self._diagonal
        out[self.low.place] = lu_solve(self._factors, right[self.low.place])
        return out
