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
from isoembed.relativity.spacetimes.checks import numbers, vector
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.surface_errors import SURE, SurfaceErrors
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry, check_geometry, check_members
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import angle_frame
from isoembed.smooth.uncertain import EXACT, UncertainFunction, Uncertainty

ON_SURFACE = 1e-9  # relative distance of a black hole that is on the surface


class Surface(ABC):
    """A closed surface X(u), u the unit vectors: a smooth map of the unit sphere with the outside outside.

    Attributes
    ----------
    center : three floats
        About which torques are.
    harmonics : Harmonics
        In which it is given.
    misfit : float
        How far it is from what it was made from, a length, root-mean-square.
    deviations : ndarray, shape (N, ...), optional
        By what its coefficients may be off, drawn at random; without them, noise of the size of the misfit.
    notes : tuple of str
        For reports.
    """

    center: Sequence[float]
    harmonics: Harmonics
    misfit: float
    deviations: Floats | None
    notes: tuple[str, ...]

    @property
    @abstractmethod
    def mean_radius(self) -> float:
        """Size in the coordinates of the slice, a length."""

    @abstractmethod
    def jet(self, u: Floats) -> Jet:
        """The map to second order in the directions u (n, 3)."""

    @abstractmethod
    def deviating(self, u: Floats) -> Iterator[Jet]:
        """Maps that this one might be, for errors."""

    def points(self, u: Floats) -> Floats:
        """The points X (n, 3) in the directions u (n, 3)."""
        return self.jet(as_directions(u)).x

    def differential(self, u: Floats) -> Floats:
        """The differential dX (n, 3, 3): ``dX @ v`` is the derivative of X along a tangent vector v."""
        u = as_directions(u)
        return np.einsum("nai,naj->nij", self.jet(u).first, np.stack(angle_frame(u), axis=1))

    def local_geometry(self, geometry: ThreeGeometry, u: Floats) -> LocalGeometry:
        """The local geometry of the surface in a slice, in the directions u (n, 3)."""
        check_geometry(geometry)
        jet = self.jet(as_directions(u))
        check_members(geometry, jet.x)
        return LocalGeometry.of(geometry, jet)

    def metric(self, geometry: ThreeGeometry) -> InducedMetric:
        """The metric that the geometry induces on the surface."""
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
        """``theta_+ = k - p`` (n,) of the light rays that leave outward; zero on an apparent horizon."""
        return self.local_geometry(geometry, u).expansion

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
        a, center = np.array(_unit("the axis", axis)), np.array(self.center)
        n, before = self.harmonics.degree + 8, np.inf
        while True:
            u, weights = gauss_rule(n, 2 * n)
            local = self.local_geometry(geometry, u)
            density = local.torque(center) @ a * weights * local.density / (8.0 * np.pi)
            J, size = float(density.sum()), float(np.abs(density).sum())
            if abs(J - before) <= 1e-13 * size or n > 128:  # change with more nodes
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
        check_geometry(geometry)
        moves = not geometry.time_symmetric
        u, weights = gauss_rule(24, 48)
        center, local = np.array(self.center), self.local_geometry(geometry, u)
        errors = SurfaceErrors.of_surface(local, self.deviating(u), center, weights)
        if self.deviations is None:
            miss = self.misfit / self.mean_radius
            errors = replace(errors, lengths=Uncertainty(miss, miss))
        errors += SurfaceErrors.of_slice(local, center, weights)
        about = None if axis is None else _unit("the axis", axis)
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
    """The metric that a slice induces on a surface; a `isoembed.smooth.TwoMetric`.

    Attributes
    ----------
    surface : Surface
    geometry : ThreeGeometry
    error : Uncertainty
        Of lengths, relative.
    """

    surface: Surface
    geometry: ThreeGeometry
    error: Uncertainty = EXACT

    def tensor(self, u: Floats) -> Floats:
        """See `isoembed.smooth.TwoMetric`."""
        return self.surface.local_geometry(self.geometry, u).q

    def deviations(self, u: Floats) -> tuple[Floats, ...]:
        """Changes (N, n, 3, 3) of the tensor that the surface's deviations and the slice's error make.

        See `isoembed.smooth.uncertain_curvature.DeviatingMetric`.
        """
        u = as_directions(u)
        jet, own = self.surface.jet(u), self.tensor(u)
        by_surface = np.stack(
            [LocalGeometry.of(self.geometry, other).q - own for other in self.surface.deviating(u)]
        )
        by_slice = self.geometry.error(lambda geometry: LocalGeometry.of(geometry, jet).q)
        return by_surface, by_slice[None] / SURE


def _unit(what: str, given: Sequence[float]) -> tuple[float, float, float]:
    """A vector of length one along a given one."""
    x = np.array(vector(what, given))
    if not x.any():
        raise InvalidParameter(f"{what} must not be zero")
    x /= np.abs(x).max()
    a, b, c = map(float, x / np.linalg.norm(x))
    return a, b, c


def as_directions(u: ArrayLike) -> Floats:
    """The directions as an array (n, 3); `InvalidParameter` if they are not directions."""
    array = numbers(u)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidParameter(f"directions must be unit vectors (n, 3), not an array {array.shape}")
    return array
