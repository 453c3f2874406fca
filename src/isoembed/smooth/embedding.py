"""Smooth embeddings of 2-metrics in spherical harmonics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.reprs import short_repr
from isoembed.smooth.extrinsic import Surface, radial_volume
from isoembed.smooth.grid_metric import sampled_on_grid
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import around
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.triangulation import SphereMesh, triangulate_metric
from isoembed.smooth.two_metric import TwoMetric, angle_frame, area_density, orthonormal_frame
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.estimate import Estimate

ROUNDING = 1e-11  # relative error of lengths attributed to rounding


@short_repr
@dataclass(frozen=True)
class SmoothEmbedding:
    """Map X from the sphere into space that approximately realizes a metric.

    Attributes
    ----------
    metric : TwoMetric
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
        Coefficients of X, in the metric's unit of length; of ambient coordinates in hyperbolic and spherical
        space.
    tolerance : float
        Largest `residual` that counts as an embedding.
    coarser : float
        Integral of H of the best map of lower degree, infinite if there is none.
    hindrance : str
        Reason why the map is not an embedding regardless of its residual: no surface of revolution has the
        metric, or the residual does not decrease any more.  Empty for an embedding.
    coordinates : SphereMap, optional
        Map u = F(v) to the metric's directions u from the directions v of the harmonics, in which the surface
        needs fewer of them.  By default the identity.
    mesh : SphereMesh, optional
        Initial triangulation.
    space : Space
        Ambient space, by default Euclidean.
    """

    metric: TwoMetric
    harmonics: Harmonics
    coefficients: Floats
    tolerance: float
    coarser: float
    hindrance: str = ""
    coordinates: SphereMap | None = None
    mesh: SphereMesh | None = field(default=None, repr=False)
    space: Space = EUCLIDEAN

    def _shown(self) -> Iterator[tuple[str, object]]:
        yield "metric", self.metric
        yield "space", self.space
        yield "degree", self.harmonics.degree
        yield "residual", self.residual
        yield "tolerance", self.tolerance
        yield "area", self.area
        yield "integrated_mean_curvature", Estimate(self.integrated_mean_curvature, self.curvature_error)
        yield "hindrance", self.hindrance

    def triangulated(self, vertices: int) -> SphereMesh:
        """Mesh of the metric with a given number of vertices: the initial one if it matches, else a new one.

        Raises
        ------
        InvalidParameter
            The number is less than 12 or more than ten million.
        """
        if self.mesh is not None and len(self.mesh.directions) == vertices:
            return self.mesh
        return triangulate_metric(sampled_on_grid(self.metric), vertices, space=self.space)

    @property
    def in_own_directions(self) -> SmoothEmbedding:
        """Surface and metric as functions of the directions of the harmonics."""
        if self.coordinates is None:
            return self
        return replace(self, metric=self._metric, coordinates=None, mesh=None)

    def points(self, u: Floats) -> Floats:
        """Points X (n, 3) in the directions u (n, 3)."""
        return self.harmonics.derivatives(self._own(u), self.coefficients)[0]

    def normals(self, u: Floats) -> Floats:
        """Outward unit normals (n, 3), in ambient coordinates."""
        return self._surface(self._own(u)).normals

    def mean_curvature(self, u: Floats) -> Floats:
        """H = (k1 + k2) / 2 (n,) of the surface, in frames of the metric; in relativity k0 = 2 H."""
        return self._shape(self._own(u))[0]

    def gaussian_curvature(self, u: Floats) -> Floats:
        """K = k + k1 k2 (n,) of the surface, where k is the curvature of space."""
        return self.space.curvature + self._shape(self._own(u))[1]

    def strain(self, u: Floats) -> Floats:
        """Largest relative error (n,) of a squared length at u."""
        return self._strain(self._own(u))

    @cached_property
    def residual(self) -> float:
        """Largest relative error of a length, at directions other than the collocation nodes."""
        apart = 0.5 * float(self._strain(fibonacci_directions(1000)).max())  # away from the nodes
        return max(apart, self._measured.residual)

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance and there is no `hindrance`."""
        return self.residual <= self.tolerance and not self.hindrance

    @property
    def area(self) -> float:
        """Area of the metric."""
        return self._measured.area

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H = (k1 + k2) / 2 over the surface; that of k0 is twice as large.

        A correction to first order in the difference of the given metric q and the metric g of the surface is
        included: ``int (H g^ab - b^ab / 2) (q - g)_ab / 2 dA``, with b the second fundamental form.  In a
        space of curvature k this is the change of int H dA + k volume; that of the volume is neglected.
        """
        return self._measured.integrated_mean_curvature

    @property
    def volume(self) -> float:
        """Enclosed volume, positive."""
        return self._measured.volume

    @property
    def least_curvature(self) -> float:
        """Least Gaussian curvature at the nodes of the quadrature."""
        return self._measured.least_curvature

    @property
    def curvature_error(self) -> float:
        """Estimated error of `integrated_mean_curvature`, in the same unit: `unsettled` and rounding."""
        rounding = self._rounding
        if self.residual <= ROUNDING:
            rounding = max(rounding, self.residual)
        return self.unsettled + rounding * abs(self.integrated_mean_curvature)

    @property
    def _rounding(self) -> float:
        """Relative rounding error of second derivatives of the harmonics."""
        return 2.0 * float(np.finfo(np.float64).eps) * self.harmonics.degree**2

    @property
    def unsettled(self) -> float:
        """Estimated change of `integrated_mean_curvature` with more harmonics or nodes.

        The sum of the second-order effect of deformations with such strains, at most three times the change
        from a lower degree, of a part of the first-order correction, and of the change from fewer nodes.  If
        the strains are at rounding level, only the last term remains.
        """
        measured = self._measured
        if self.residual <= ROUNDING:
            return measured.change
        value = measured.integrated_mean_curvature
        relative = (measured.least_curvature - self.space.curvature) * measured.area / (4.0 * np.pi)
        # Ratio of displacements to strains, large for surfaces with small or negative K.
        softness = 50.0 if relative < 0.05 else 10.0
        lower = 3.0 * abs(value - self.coarser)
        displaced = softness * measured.strain
        # In curved space the first-order change of the volume is neglected in int H.
        volume = abs(self.space.curvature * measured.volume)
        moved = min(lower, displaced**2 * abs(value) + displaced * volume)
        return 0.03 * abs(measured.correction) + moved + measured.change

    @cached_property
    def _measured(self) -> _Measures:
        """Measures by quadrature with an increasing number of nodes, until the integral of H converges."""
        before = change = np.inf
        n = 2 + self.harmonics.degree
        while True:
            n = int(np.ceil(1.4 * n))
            measures = self._measures(n, abs(before))
            value = measures.integrated_mean_curvature
            # If the correction is large, more nodes do not help.
            enough = max(1e-13 * abs(value), 0.01 * abs(measures.correction))
            last = n > 1000 or n * around(n, self.harmonics) > 500_000
            if measures.change <= enough or measures.change > 0.9 * change or last:
                return measures
            change = measures.change
            before = value

    def _measures(self, n: int, before: float) -> _Measures:
        """Measures by quadrature on n circles, and the change from a previous integral of H."""
        transform = SphereTransform(self.harmonics, n, around(n, self.harmonics))
        q = self._metric.tensor(transform.u)
        frames = orthonormal_frame(transform.u, q)
        areas = transform.weights * area_density(q)
        frames = np.einsum("nai,nbi->nab", frames, np.stack(angle_frame(transform.u), axis=1))
        points = transform.values(self.coefficients)
        surface = Surface.of(self.space, points, frames @ transform.gradients(self.coefficients))
        pairs = -np.einsum("npi,ni->np", transform.hessians(self.coefficients), surface.conormals)
        second = surface.second(frames @ pairs[:, [[0, 1], [1, 2]]] @ frames.transpose(0, 2, 1))
        g, stretch = surface.metric, surface.stretch
        # In two dimensions the inverse is the matrix of cofactors over the determinant, stretch^2.
        cofactors = np.stack([g[:, 1, 1], -g[:, 0, 1], -g[:, 0, 1], g[:, 0, 0]], axis=1).reshape(-1, 2, 2)
        inverse = cofactors / stretch[:, None, None] ** 2
        shape = inverse @ second
        H = 0.5 * np.einsum("naa->n", shape)
        lacking = np.eye(2) - g
        weights = H[:, None, None] * inverse - 0.5 * shape @ inverse
        surface_areas = areas * stretch
        value = float(surface_areas @ H)
        correction = 0.5 * float(surface_areas @ np.einsum("nab,nab->n", weights, lacking))
        squares = np.einsum("nab,nab->n", lacking, lacking)
        heights = np.einsum("ni,ni->n", points, surface.conormals)
        if not self.space.is_euclidean:
            heights *= radial_volume(self.space, points)
        extrinsic = second[:, 0, 0] * second[:, 1, 1] - second[:, 0, 1] ** 2
        return _Measures(
            area=float(areas.sum()),
            integrated_mean_curvature=value + correction,
            correction=correction,
            change=abs(value + correction - before),
            volume=float(surface_areas @ heights) / 3.0,
            least_curvature=self.space.curvature + float(np.min(extrinsic)),
            strain=float(np.sqrt(areas @ squares / areas.sum())),
            residual=0.5 * float(np.abs(np.linalg.eigvalsh(lacking)).max()),
        )

    @cached_property
    def _metric(self) -> TwoMetric:
        """Metric as a function of the directions of the harmonics."""
        return metric_in(self.metric, self.coordinates)

    def _own(self, u: Floats) -> Floats:
        """Directions of the harmonics (n, 3) for those of the metric."""
        return u if self.coordinates is None else self.coordinates.inverse(u)

    def _frames(self, u: Floats) -> Floats:
        return orthonormal_frame(u, self._metric.tensor(u))

    def _surface(self, u: Floats) -> Surface:
        points, gradients, _ = self.harmonics.derivatives(u, self.coefficients)
        return Surface.of(self.space, points, np.einsum("nai,nci->nac", self._frames(u), gradients))

    def _strain(self, u: Floats) -> Floats:
        s = self._surface(u).tangents.strains
        middle, half = 0.5 * (s[:, 0] + s[:, 2]), 0.5 * (s[:, 0] - s[:, 2])
        return np.abs(middle) + np.sqrt(half**2 + 0.5 * s[:, 1] ** 2)

    def _shape(self, u: Floats) -> tuple[Floats, Floats]:
        """H and the product of the principal curvatures (n,)."""
        frames = self._frames(u)
        points, gradients, hessians = self.harmonics.derivatives(u, self.coefficients)
        surface = Surface.of(self.space, points, np.einsum("nai,nci->nac", frames, gradients))
        h = surface.second(
            -np.einsum("nai,nbj,ncij,nc->nab", frames, frames, hessians, surface.conormals, optimize=True)
        )
        H = 0.5 * (h[:, 0, 0] + h[:, 1, 1])
        return H, h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] ** 2


@dataclass(frozen=True)
class _Measures:
    """Measures of a surface by quadrature."""

    area: float
    integrated_mean_curvature: float
    correction: float  # first-order part of the integral
    change: float  # from the previous rule
    volume: float
    least_curvature: float
    strain: float  # root mean square
    residual: float
