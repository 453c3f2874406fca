"""Closed surfaces in a slice, as maps of the unit sphere with derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.checks import numbers, unit_vector
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.surface_errors import SURE, SurfaceErrors
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry, check_geometry, check_members
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import angle_frame
from isoembed.smooth.uncertain import EXACT, UncertainFunction, Uncertainty

ON_SURFACE = 1e-9  # largest relative distance of a black hole on the surface


class Surface(ABC):
    """Closed surface X(u) over unit vectors u: a smooth orientation-preserving map of the unit sphere.

    Attributes
    ----------
    center : three floats
        Center for torques.
    harmonics : Harmonics
        Harmonics of its representation.
    misfit : float
        Root-mean-square distance from the data that it represents.
    deviations : ndarray, shape (N, ...), optional
        Random samples of the error of its coefficients; by default noise of the size of the misfit.
    notes : tuple of str
        Notes for reports.
    """

    center: Sequence[float]
    harmonics: Harmonics
    misfit: float
    deviations: Floats | None
    notes: tuple[str, ...]

    @property
    @abstractmethod
    def mean_radius(self) -> float:
        """Mean radius in slice coordinates."""

    @abstractmethod
    def jet(self, u: Floats) -> Jet:
        """Second-order jet of the map in the directions u (n, 3)."""

    @abstractmethod
    def deviating(self, u: Floats) -> Iterator[Jet]:
        """Jets of random samples of the surface within its errors."""

    def points(self, u: Floats) -> Floats:
        """Points X (n, 3) in the directions u (n, 3)."""
        return self.jet(as_directions(u)).x

    def differential(self, u: Floats) -> Floats:
        """Differential dX (n, 3, 3): ``dX @ v`` is the derivative of X along a tangent vector v."""
        u = as_directions(u)
        return np.einsum("nai,naj->nij", self.jet(u).first, np.stack(angle_frame(u), axis=1))

    def local_geometry(self, geometry: ThreeGeometry, u: Floats) -> LocalGeometry:
        """Local geometry of the surface in a slice, in the directions u (n, 3)."""
        check_geometry(geometry)
        jet = self.jet(as_directions(u))
        check_members(geometry, jet.x)
        return LocalGeometry.of(geometry, jet)

    def metric(self, geometry: ThreeGeometry) -> InducedMetric:
        """Induced metric of the surface."""
        return InducedMetric(self, geometry)

    def mean_curvature(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) for the outward normal, in the directions u (n, 3); 2 / r on a flat sphere."""
        return self.local_geometry(geometry, u).mean_curvature

    def momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,) in the directions u (n, 3)."""
        return self.local_geometry(geometry, u).momentum

    def normal_momentum(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``K(., n)`` as tangent vectors (n, 3) of the unit sphere at u (n, 3): see `SurfaceData`."""
        return self.local_geometry(geometry, u).normal_momentum()

    def expansion(self, geometry: ThreeGeometry, u: Floats) -> Floats:
        """``theta_+ = k - p`` (n,), the expansion of outgoing light rays; zero on an apparent horizon."""
        return self.local_geometry(geometry, u).expansion

    def angular_momentum(self, geometry: ThreeGeometry, axis: Sequence[float]) -> float:
        """``J = 1 / (8 pi) int K_ij phi^i n^j dA``, a length squared, with ``phi = axis x (x - center)``.

        It is meaningful if phi is an approximate symmetry of the surface; see `isoembed.relativity.find_spin`
        for the axis.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats
            Nonzero vector.
        """
        a, center = np.array(unit_vector("the axis", axis)), np.array(self.center)
        n, before = self.harmonics.degree + 8, np.inf
        while True:
            u, weights = gauss_rule(n, 2 * n)
            local = self.local_geometry(geometry, u)
            density = local.torque(center) @ a * weights * local.density / (8.0 * np.pi)
            J, size = float(density.sum()), float(np.abs(density).sum())
            if abs(J - before) <= 1e-13 * size or n > 128:  # converged in the number of nodes
                return J
            n, before = 2 * n, J

    def data(
        self,
        geometry: ThreeGeometry,
        axis: Sequence[float] | None = None,
        marginal: bool = False,
        name: str = "",
    ) -> SurfaceData:
        """Data for quasi-local energies.

        Their errors include those from the misfit of the surface and from the geometry.

        Parameters
        ----------
        geometry : ThreeGeometry
        axis : three floats, optional
            Axis of the angular momentum; by default determined by `isoembed.relativity.find_spin`.
        marginal : bool
            Whether the surface is a horizon, so that the mean curvature vector is null by definition.
        name : str
            Name for reports.

        Raises
        ------
        InvalidMetric
            The slice's metric is not positive definite, or its extrinsic curvature not finite, on the
            surface; the message names a point.
        """
        u, weights = gauss_rule(24, 48)
        center, local = np.array(self.center), self.local_geometry(geometry, u)
        moves = not geometry.time_symmetric
        errors = SurfaceErrors.of_surface(local, self.deviating(u), center, weights)
        if self.deviations is None:
            miss = self.misfit / self.mean_radius
            errors = replace(errors, lengths=Uncertainty(miss, miss))
        errors += SurfaceErrors.of_slice(local, center, weights)
        about = None if axis is None else unit_vector("the axis", axis)
        J = 0.0 if not moves else about and self.angular_momentum(geometry, about)

        def moving(values: Callable[[Floats], Floats], error: Uncertainty) -> UncertainFunction | None:
            return UncertainFunction(values, error) if moves else None

        return SurfaceData(
            metric=InducedMetric(self, geometry, errors.lengths),
            mean_curvature=UncertainFunction(
                lambda u: self.mean_curvature(geometry, u), errors.mean_curvature
            ),
            momentum=moving(lambda u: self.momentum(geometry, u), errors.momentum),
            normal_momentum=moving(lambda u: self.normal_momentum(geometry, u), errors.normal_momentum),
            angular_momentum=J,
            marginal=marginal,
            shape=self.points,
            name=name,
            notes=(*self.notes, *geometry.notes),
            axis=about,
            torque=moving(lambda u: self.local_geometry(geometry, u).torque(center), errors.torque),
        )


@dataclass(frozen=True)
class InducedMetric:
    """Induced metric of a surface in a slice; a `isoembed.smooth.TwoMetric`.

    Attributes
    ----------
    surface : Surface
    geometry : ThreeGeometry
    error : Uncertainty
        Relative errors of lengths.
    """

    surface: Surface
    geometry: ThreeGeometry
    error: Uncertainty = EXACT

    def tensor(self, u: Floats) -> Floats:
        """See `isoembed.smooth.TwoMetric`."""
        return self.surface.local_geometry(self.geometry, u).q

    def deviations(self, u: Floats) -> tuple[Floats, ...]:
        """Changes (N, n, 3, 3) of the tensor from deviations of the surface and errors of the slice.

        See `isoembed.smooth.uncertain_curvature.DeviatingMetric`.
        """
        u = as_directions(u)
        jet, own = self.surface.jet(u), self.tensor(u)
        by_surface = np.stack(
            [LocalGeometry.of(self.geometry, other).q - own for other in self.surface.deviating(u)]
        )
        by_slice = self.geometry.error(lambda geometry: LocalGeometry.of(geometry, jet).q)
        return by_surface, by_slice[None] / SURE


def as_directions(u: ArrayLike) -> Floats:
    """Checked directions (n, 3).  Raises `InvalidParameter`: they are not directions."""
    array = numbers(u)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidParameter(f"directions must be unit vectors (n, 3), not an array {array.shape}")
    return array
