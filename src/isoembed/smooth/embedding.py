"""A smooth surface in R^3 that realizes a 2-metric, in spherical harmonics: it measures itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.grid_metric import sampled_on_grid
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import MetricSamples, around, strains
from isoembed.smooth.triangulation import SphereMesh, triangulate_metric
from isoembed.smooth.two_metric import TwoMetric, orthonormal_frame
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class MeasureThresholds:
    """Thresholds of the measures of a smooth embedding."""

    rounding: float = threshold(1e-11, "relative", "Error of a length that is rounding.")
    more: int = threshold(2, "count", "Heights of nodes more than the degree, to begin with.")
    denser: float = threshold(1.4, "relative", "Heights of nodes over those before.")
    settled: float = threshold(1e-13, "relative", "Change of int H with which the nodes suffice.")
    negligible: float = threshold(0.01, "relative", "The same, of the change from lower degree.")
    scattered: int = threshold(1000, "count", "Directions beside the nodes at which it is measured.")
    highest: int = threshold(1000, "count", "Heights of nodes after which there are no more.")
    most: int = threshold(15_000_000, "count", "Harmonics at nodes after which there are no more.")


MEASURE = MeasureThresholds()


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
    hindrance : str
        Why no surface has the metric, where that is known.
    mesh : SphereMesh, optional
        The triangulation that the embedding began with.
    """

    metric: TwoMetric
    harmonics: Harmonics
    coefficients: Floats
    tolerance: float
    coarser: float
    hindrance: str = ""
    mesh: SphereMesh | None = field(default=None, repr=False)

    def triangulated(self, vertices: int) -> SphereMesh:
        """A mesh of the metric with so many vertices: the one that the embedding began with, or a new one.

        Raises
        ------
        InvalidParameter
            There would be fewer than 12 vertices or more than ten million.
        """
        if self.mesh is not None and len(self.mesh.directions) == vertices:
            return self.mesh
        return triangulate_metric(sampled_on_grid(self.metric), vertices)

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
        """The largest relative error of a length, at directions where the equations were not solved."""
        u = np.concatenate([self._measured.u, fibonacci_directions(MEASURE.scattered)])
        return 0.5 * float(self.strain(u).max())

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance and nothing is known to stand against it."""
        return self.residual <= self.tolerance and not self.hindrance

    @property
    def area(self) -> float:
        """Area of the metric."""
        return self._measured.area

    @property
    def integrated_mean_curvature(self) -> float:
        """The integral of H = (k1 + k2) / 2 over the surface; that of k0 is twice as much."""
        return self._measured.integrated_mean_curvature

    @property
    def volume(self) -> float:
        """Enclosed volume, positive."""
        return self._measured.volume

    @property
    def least_curvature(self) -> float:
        """The least Gaussian curvature at the nodes of the quadrature."""
        return self._measured.least_curvature

    @property
    def curvature_error(self) -> float:
        """Estimated error of `integrated_mean_curvature`, in the same unit: `unsettled` and rounding."""
        rounding = self._rounding
        if self.residual <= MEASURE.rounding:
            rounding = max(rounding, self.residual)
        return self.unsettled + rounding * abs(self.integrated_mean_curvature)

    @property
    def _rounding(self) -> float:
        """Rounding of second derivatives of the harmonics, relative."""
        return 2.0 * float(np.finfo(np.float64).eps) * self.harmonics.degree**2

    @property
    def unsettled(self) -> float:
        """Change of `integrated_mean_curvature` that more harmonics or nodes may make.

        It is the change from lower degree and at least what the strains make, their square; nothing where
        these are rounding.  The change from fewer nodes adds to it.
        """
        value = self.integrated_mean_curvature
        if self.residual <= MEASURE.rounding:
            return self._measured.change
        strained = max(abs(value - self.coarser), self.residual**2 * abs(value))
        return strained + self._measured.change

    @cached_property
    def _measured(self) -> _Measures:
        """Measures by quadrature with more and more nodes, until the integral of H settles."""
        before = np.inf
        n = MEASURE.more + self.harmonics.degree
        while True:
            n = int(np.ceil(MEASURE.denser * n))
            samples = MetricSamples.of(self.metric, n, around(n, self.harmonics))
            normals, H, K = self._shape(samples.u, samples.frames)
            value = float(samples.areas @ H)
            change = abs(value - before)
            nodes = MEASURE.denser**2 * len(samples.u)
            # Where lower degree was far from this one, so is this from what it will be.
            enough = max(MEASURE.settled, self._rounding) * abs(value)
            if np.isfinite(self.coarser):
                enough = max(enough, MEASURE.negligible * abs(value - self.coarser))
            if change <= enough or n > MEASURE.highest or nodes * self.harmonics.size > MEASURE.most:
                heights = np.einsum("ni,ni->n", self.points(samples.u), normals)
                return _Measures(
                    u=samples.u,
                    area=float(samples.areas.sum()),
                    integrated_mean_curvature=value,
                    change=change,
                    volume=float(samples.areas @ heights) / 3.0,
                    least_curvature=float(K.min()),
                )
            before = value

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


@dataclass(frozen=True)
class _Measures:
    """Measures of a surface by quadrature at the nodes u (n, 3)."""

    u: Floats
    area: float
    integrated_mean_curvature: float
    change: float  # of int H, from the rule before
    volume: float
    least_curvature: float
