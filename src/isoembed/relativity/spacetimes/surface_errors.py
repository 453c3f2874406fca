"""Error propagation from position and slice to metric, curvature and momentum."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry, SliceFields
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.uncertain import Uncertainty

SURE = 3.0  # stated errors in standard deviations


@dataclass(frozen=True)
class SurfaceErrors:
    """Errors of the data of a surface, from errors of the surface or its slice.

    Attributes
    ----------
    lengths : Uncertainty
        Relative errors of lengths.
    mean_curvature, momentum, normal_momentum : Uncertainty
        Errors of k, p and K(., n).
    torque : Uncertainty
        Errors of the torques of `SurfaceData`.  Their means over the surface are much more accurate, as J
        about a symmetry axis is independent of the surface.
    """

    lengths: Uncertainty
    mean_curvature: Uncertainty
    momentum: Uncertainty
    normal_momentum: Uncertainty
    torque: Uncertainty

    @classmethod
    def of_surface(
        cls, local: LocalGeometry, deviating: Iterable[Jet], center: Floats, weights: Floats
    ) -> SurfaceErrors:
        """Errors from random samples of the surface.

        Parameters
        ----------
        local : LocalGeometry
            Local geometry at the nodes of a quadrature over the unit sphere.
        deviating : iterable of Jet
            Random samples of the surface within its errors, in the same directions.
        center : ndarray, shape (3,)
            Center for torques.
        weights : ndarray, shape (n,)
            Weights of the quadrature.
        """
        unit, geometry = _area_unit(local), _geometry(local)
        base = _quantities(local, center, unit)
        changes = [_quantities(LocalGeometry.of(geometry, jet), center, unit) - base for jet in deviating]
        return cls._of(local, SURE * np.array(changes), weights, unit)

    @classmethod
    def of_slice(cls, local: LocalGeometry, center: Floats, weights: Floats) -> SurfaceErrors:
        """Errors from those of the slice, with parameters as in `of_surface`.

        Errors of averages come from samples of the noise on a grid, and from a fraction of other errors.
        """
        unit, own = _area_unit(local), _geometry(local)
        base = _quantities(local, center, unit)

        def quantities(geometry: ThreeGeometry) -> Floats:
            if geometry is own:
                return base
            return _quantities(LocalGeometry.of(geometry, local.jet), center, unit)

        errors = cls._of(
            *(local, own.error(quantities)[None], weights, unit),
            averaged=0.3,  # truncation errors average out in part
            scattered=0.03,
        )
        if changes := [quantities(other) - base for other in own.deviating(local.jet.x)]:
            errors += cls._of(local, SURE * np.array(changes), weights, unit)
        return errors

    @classmethod
    def _of(
        cls,
        local: LocalGeometry,
        changes: Floats,
        weights: Floats,
        unit: float,
        averaged: float = 1.0,
        scattered: float = 0.0,
    ) -> SurfaceErrors:
        """Errors from changes (N, 9, n) of the quantities at the nodes of a quadrature.

        Errors of averages are the larger of given fractions of the averaged and root-mean-square changes.
        """
        harmonics = Harmonics(2, 2)  # weights of the averages
        smooth = weights[:, None] * harmonics.values(local.jet.u)
        # Each degree has half the weight of the one below.
        smooth *= 0.5 ** harmonics.labels[0] / np.sqrt(4.0 * np.pi)
        points = np.sqrt(np.mean(changes**2, axis=0))
        means = np.sqrt(np.mean(np.sum((changes @ smooth) ** 2, axis=2), axis=0))
        means = np.maximum(averaged * means, scattered * np.sqrt(points**2 @ weights / (4.0 * np.pi)))

        def uncertainty(part: slice) -> Uncertainty:
            pointwise = float(np.linalg.norm(points[part], axis=0).max())
            return Uncertainty(pointwise, float(np.linalg.norm(means[part])))

        density = local.density / unit
        totals = averaged * np.sqrt(np.mean(np.sum((changes[:, 6:] @ weights) ** 2, axis=1)))
        if scattered:
            totals = max(totals, 4.0 * np.pi * float(np.linalg.norm(means[6:])))
        largest = (np.linalg.norm(points[6:], axis=0) / density).max()
        return cls(
            lengths=uncertainty(slice(1)),
            mean_curvature=uncertainty(slice(1, 2)),
            momentum=uncertainty(slice(2, 3)),
            normal_momentum=uncertainty(slice(3, 6)),
            torque=Uncertainty(float(largest), float(totals / (weights @ density))),
        )

    def __add__(self, other: SurfaceErrors) -> SurfaceErrors:
        return SurfaceErrors(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(SurfaceErrors)))


def _geometry(local: LocalGeometry) -> ThreeGeometry:
    assert isinstance(local.fields, SliceFields)
    return local.fields.geometry


def _area_unit(local: LocalGeometry) -> float:
    """Mean area density as a unit, to avoid overflow and underflow of squared densities."""
    return float(local.density.mean())


def _quantities(local: LocalGeometry, center: Floats, unit: float) -> Floats:
    """Logarithms of lengths, k, p, K(., n) and torque densities of a surface, (9, n)."""
    density = local.density / unit
    lengths = 0.5 * np.log(density)
    if _geometry(local).time_symmetric:
        return np.stack([lengths, local.mean_curvature, *np.zeros((7, len(lengths)))])
    torques = density * local.torque(center).T
    return np.stack([lengths, local.mean_curvature, local.momentum, *local.normal_momentum().T, *torques])
