"""First variation of a smooth embedding in R^3 with respect to its metric.

A change h of the metric requires displacements dX with ``2 sym (X_a . dX_b) = h_ab``, where X_a are the
derivatives along a frame.  They are expanded in harmonics and computed by least squares over the area,
without translation and rotation; the transpose maps derivatives with respect to the coefficients to those
with respect to the metric.  For the integral of H there is a closed form (of Schlaefli type; Rivin and
Schlenker, The Schlaefli formula in Einstein manifolds with boundary, 1999),

    d int H dA = 1/2 int (H g^ab - b^ab / 2) h_ab dA,

where b is the second fundamental form, positive for convex surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.extrinsic import Surface
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import OVERSAMPLING, IsometrySystem, LinearizedStrains, MetricSamples
from isoembed.smooth.sphere_map import metric_in
from isoembed.smooth.transforms import resized

HIGHEST_DEGREE = 36  # limited by the size of the normal equations


@dataclass(frozen=True, eq=False)
class MetricDerivatives:
    """Derivatives of a smooth embedding in R^3 with respect to its metric.

    Changes of the metric and gradients with respect to it are symmetric matrices (n, 3, 3) at the
    `directions`, as in `TwoMetric.tensor`: a function with gradient G changes by ``sum(G * changes)``.

    Attributes
    ----------
    surface : SmoothEmbedding
    harmonics : Harmonics
        Harmonics of displacements.
    directions : ndarray, shape (n, 3)
        Directions at which changes of the metric are given.
    """

    surface: SmoothEmbedding
    harmonics: Harmonics
    directions: Floats
    _samples: MetricSamples
    _tangents: Floats  # frames of the samples as tangents at the directions of the metric
    _linear: LinearizedStrains

    @classmethod
    def of(cls, surface: SmoothEmbedding, degree: int | None = None) -> MetricDerivatives:
        """Factor the normal equations of the displacements.

        Parameters
        ----------
        surface : SmoothEmbedding
        degree : int, optional
            Degree of the displacements, at least that of the surface; by default that, but at least 16.

        Raises
        ------
        InvalidParameter
            The surface is not in R^3 or misses its tolerance, or the degree is too high.
        """
        degree = max(surface.harmonics.degree, 16 if degree is None else degree)
        if not surface.space.is_euclidean:
            raise InvalidParameter(
                f"derivatives by the metric need surfaces in R^3, not in {surface.space!r}"
            )
        if not surface.converged:
            raise InvalidParameter(f"the surface misses its metric by {surface.residual:.1e}")
        if degree > HIGHEST_DEGREE:
            raise InvalidParameter(
                f"displacements would be in harmonics of degree {degree}, and the maximum is {HIGHEST_DEGREE}"
            )
        harmonics, heights = Harmonics(degree, degree), int(np.ceil(OVERSAMPLING * (degree + 1)))
        samples = MetricSamples.of(metric_in(surface.metric, surface.coordinates), heights, 2 * heights)
        system = IsometrySystem.of(harmonics, samples)
        linear = system.linearized(resized(surface.coefficients, surface.harmonics, harmonics))
        directions, tangents = samples.u, samples.frames
        if surface.coordinates is not None:
            slope = surface.coordinates.differential(directions)
            directions, tangents = surface.coordinates.forward(directions), tangents @ slope.mT
        return cls(surface, harmonics, directions, samples, tangents, linear)

    def jvp(self, changes: ArrayLike) -> Floats:
        """Changes (size, 3) of the coefficients of X, without translation and rotation.

        Parameters
        ----------
        changes : array_like, shape (n, 3, 3)
            Changes of the metric.

        Raises
        ------
        InvalidParameter
            The changes have a wrong shape, are not finite, or are not resolved by the degree.
        """
        h = np.asarray(changes, dtype=np.float64)
        if h.shape != (len(self.directions), 3, 3):
            raise InvalidParameter(
                f"the changes have the shape {h.shape}, not ({len(self.directions)}, 3, 3)"
            )
        if not np.isfinite(h).all():
            raise InvalidParameter(
                f"the change at direction {int(np.argmin(np.isfinite(h).all(axis=(1, 2))))} is not finite"
            )
        along = np.einsum("nai,nij,nbj->nab", self._tangents, h, self._tangents)
        strains = np.stack([along[:, 0, 0], np.sqrt(0.5) * (along[:, 0, 1] + along[:, 1, 0]), along[:, 1, 1]])
        displacements, left = self._linear.displacements(strains.T)
        if left > 1e-3:  # largest admissible relative residual
            raise InvalidParameter(
                f"displacements in harmonics of degree {self.harmonics.degree} leave {left:.1e} of the "
                "change of the metric: a higher degree is needed"
            )
        return displacements

    def vjp(self, gradient: ArrayLike) -> Floats:
        """Gradient (n, 3, 3) of a function with respect to the metric, from that for the coefficients of X.

        Parameters
        ----------
        gradient : array_like, shape (size, 3)
            Gradient of a function invariant under rigid motions; for other functions, only displacements
            without translation and rotation count.

        Raises
        ------
        InvalidParameter
            The gradient has a wrong shape or is not finite.
        """
        g = np.asarray(gradient, dtype=np.float64)
        if g.shape != (self.harmonics.size, 3) or not np.isfinite(g).all():
            raise InvalidParameter(
                f"the gradient of shape {g.shape} is not one of {self.harmonics.size} finite triples"
            )
        first, mixed, second = self._linear.by_strains(g).T
        return self._tensors(first, np.sqrt(0.5) * mixed, second)

    def velocities(self, u: Floats, displacements: Floats) -> Floats:
        """Displacements (n, 3) of the points in the directions u (n, 3), from coefficients (size, 3)."""
        v = u if self.surface.coordinates is None else self.surface.coordinates.inverse(u)
        return self.harmonics.values(v) @ displacements

    @cached_property
    def area(self) -> Floats:
        """Gradient (n, 3, 3) of the area."""
        half = 0.5 * self._samples.areas
        return self._tensors(half, np.zeros_like(half), half)

    @cached_property
    def volume(self) -> Floats:
        """Gradient (n, 3, 3) of the enclosed volume."""
        flux = (self._samples.areas * self._shape.stretch)[:, None] * self._shape.conormals
        return self.vjp(self.harmonics.values(self._samples.u).T @ flux)

    @cached_property
    def integrated_mean_curvature(self) -> Floats:
        """Gradient (n, 3, 3) of the integral of H = (k1 + k2) / 2."""
        shape = self._shape
        bent = self.harmonics.second_along(self._samples.u, self._samples.frames, self._coefficients)
        b = shape.second(-np.einsum("nabc,nc->nab", bent, shape.conormals))
        inverse = np.linalg.inv(shape.metric)
        mixed = inverse @ b
        H = 0.5 * np.einsum("naa->n", mixed)
        weights = 0.5 * (H[:, None, None] * inverse - 0.5 * mixed @ inverse)
        weights *= (self._samples.areas * shape.stretch)[:, None, None]
        return self._tensors(weights[:, 0, 0], weights[:, 0, 1], weights[:, 1, 1])

    @cached_property
    def _coefficients(self) -> Floats:
        return resized(self.surface.coefficients, self.surface.harmonics, self.harmonics)

    @cached_property
    def _shape(self) -> Surface:
        """Surface at the samples."""
        Y, along = self.harmonics.along(self._samples.u, self._samples.frames)
        return Surface.of(self.surface.space, Y @ self._coefficients, along @ self._coefficients)

    def _tensors(self, first: Floats, mixed: Floats, second: Floats) -> Floats:
        """Matrices (n, 3, 3) from contravariant components along the frames."""
        t1, t2 = self._tangents[:, 0], self._tangents[:, 1]
        across = t1[:, :, None] * t2[:, None, :]
        return (
            first[:, None, None] * t1[:, :, None] * t1[:, None, :]
            + mixed[:, None, None] * (across + across.mT)
            + second[:, None, None] * t2[:, :, None] * t2[:, None, :]
        )
