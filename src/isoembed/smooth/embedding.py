"""A smooth surface in R^3 that realizes a 2-metric, in spherical harmonics: it measures itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import MetricSamples, strains
from isoembed.smooth.two_metric import TwoMetric, orthonormal_frame

Floats = NDArray[np.float64]

ROUNDING = 1e-11  # of a length: strains do not get much smaller
CHECKED = 1.6  # nodes over coefficients, each way: other nodes than those that the equations were solved at


@dataclass(frozen=True)
class SmoothEmbedding:
    """A map X from the sphere into R^3 that is to realize a metric.

    Attributes
    ----------
    metric : TwoMetric
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
        Of X in the harmonics, in the metric's unit of length.
    tolerance : float
        Largest `residual` that counts as an embedding.
    coarser : float
        The integral of H of the best map of lower degree, infinite if there is none.
    obstruction : str
        Why no surface has the metric, where that is known.
    """

    metric: TwoMetric
    harmonics: Harmonics
    coefficients: Floats
    tolerance: float
    coarser: float
    obstruction: str = ""

    def points(self, u: Floats) -> Floats:
        """The points X(u) (n, 3) in the directions u (n, 3)."""
        return self.harmonics.values(u) @ self.coefficients

    def normals(self, u: Floats) -> Floats:
        """The outward unit normals (n, 3)."""
        return self._shape(u, self._frames(u))[0]

    def mean_curvature(self, u: Floats) -> Floats:
        """H = (k1 + k2) / 2 (n,) of the surface in the metric's frames; relativity writes k0 = 2 H."""
        return self._shape(u, self._frames(u))[1]

    def gaussian_curvature(self, u: Floats) -> Floats:
        """K = k1 k2 (n,) of the surface."""
        return self._shape(u, self._frames(u))[2]

    def strain(self, u: Floats) -> Floats:
        """The largest relative error (n,) of a squared length at u."""
        _, B = self.harmonics.along(u, self._frames(u))
        s = strains(B @ self.coefficients)
        middle, half = 0.5 * (s[:, 0] + s[:, 2]), 0.5 * (s[:, 0] - s[:, 2])
        return np.abs(middle) + np.sqrt(half**2 + 0.5 * s[:, 1] ** 2)

    @cached_property
    def residual(self) -> float:
        """The largest relative error of a length, at nodes where the equations were not solved."""
        return 0.5 * float(self.strain(self._samples.u).max())

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance and nothing is known to stand against it."""
        return self.residual <= self.tolerance and not self.obstruction

    @cached_property
    def area(self) -> float:
        """Of the metric."""
        return float(self._samples.areas.sum())

    @cached_property
    def integrated_mean_curvature(self) -> float:
        """The integral of H = (k1 + k2) / 2 over the surface; that of k0 is twice as much."""
        return float(self._samples.areas @ self._shape(self._samples.u, self._samples.frames)[1])

    @property
    def curvature_error(self) -> float:
        """Estimated error of `integrated_mean_curvature`, in the same unit.

        It is the change from lower degree, and at least what the strains make where they are resolved: their
        square.  Strains that are rounding leave rounding.
        """
        value = abs(self.integrated_mean_curvature)
        if self.residual <= ROUNDING:
            return self.residual * value
        return max(abs(self.integrated_mean_curvature - self.coarser), self.residual**2 * value)

    @cached_property
    def volume(self) -> float:
        """Enclosed volume, positive."""
        u, frames = self._samples.u, self._samples.frames
        return (
            float(self._samples.areas @ np.einsum("ni,ni->n", self.points(u), self._shape(u, frames)[0]))
            / 3.0
        )

    @cached_property
    def least_curvature(self) -> float:
        """The least Gaussian curvature at the nodes of the quadrature."""
        return float(self._shape(self._samples.u, self._samples.frames)[2].min())

    @cached_property
    def _samples(self) -> MetricSamples:
        return MetricSamples.enough_for(self.metric, self.harmonics, CHECKED)

    def _frames(self, u: Floats) -> Floats:
        return orthonormal_frame(u, self.metric.tensor(u))

    def _shape(self, u: Floats, frames: Floats) -> tuple[Floats, Floats, Floats]:
        """Normals (n, 3), H and K (n,)."""
        _, B = self.harmonics.along(u, frames)
        X1, X2 = np.moveaxis(B @ self.coefficients, 1, 0)
        normals = np.cross(X1, X2)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        second = self.harmonics.second_along(u, frames, self.coefficients)
        h = -np.einsum("nabi,ni->nab", second, normals)
        H = 0.5 * (h[:, 0, 0] + h[:, 1, 1])
        return normals, H, h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] ** 2
