"""Normals, second fundamental form and volume element of smooth surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import hyp2f1

from isoembed.arrays import Floats
from isoembed.smooth.isometry import Tangents, flat_tangents, tangents_in
from isoembed.space import Space


@dataclass(frozen=True)
class Surface:
    """Surface at n points.

    Attributes
    ----------
    space : Space
    points : ndarray, shape (n, 3)
        Points in ambient coordinates.
    tangents : Tangents
        Derivatives along two vectors at each point.
    conormals : ndarray, shape (n, 3)
        Outward unit normals, with the index lowered by the metric of space.
    stretch : ndarray, shape (n,)
        Areas of the parallelograms spanned by the derivatives.
    """

    space: Space
    points: Floats
    tangents: Tangents
    conormals: Floats
    stretch: Floats

    @classmethod
    def of(cls, space: Space, points: Floats, vectors: Floats) -> Surface:
        """Surface from the points (n, 3) and the derivatives (n, 2, 3)."""
        across = np.cross(vectors[:, 0], vectors[:, 1])
        if space.is_euclidean:
            stretch = np.linalg.norm(across, axis=1)
            return cls(space, points, flat_tangents(vectors), across / stretch[:, None], stretch)
        # The inverse of the metric I + k x x / w^2 of space is I - k x x, and its determinant 1 / w^2.
        along = np.einsum("ni,ni->n", across, points)
        length = np.sqrt(np.einsum("ni,ni->n", across, across) - space.curvature * along**2)
        tangents = tangents_in(space, points, vectors)
        return cls(space, points, tangents, across / length[:, None], length / space.heights(points))

    @property
    def metric(self) -> Floats:
        """Inner products (n, 2, 2) of the derivatives."""
        return self.tangents.vectors @ self.tangents.lowered.transpose(0, 2, 1)

    @property
    def normals(self) -> Floats:
        """Outward unit normals (n, 3)."""
        return self.conormals - self.space.curvature * self._heights[:, None] * self.points

    def second(self, bending: Floats) -> Floats:
        """Second fundamental form (n, 2, 2), positive for convex surfaces.

        `bending` is its value in R^3: minus the second derivatives of the coordinates along the conormals.
        """
        if self.space.is_euclidean:
            return bending
        return bending - (self.space.curvature * self._heights)[:, None, None] * self.metric

    @property
    def _heights(self) -> Floats:
        return np.asarray(np.einsum("ni,ni->n", self.points, self.conormals))


def radial_volume(space: Space, points: Floats) -> Floats:
    """Factors (n,) of curved space in the volume of the cone from the origin to a surface element.

    The volume is one third of area times ``points . conormals`` times this factor, by the radial vector field
    of divergence 1, which has length ``int sn^2 / sn^2``.
    """
    square = space.curvature * np.einsum("ni,ni->n", points, points)
    return np.asarray(hyp2f1(0.5, 1.5, 2.5, square)) * space.heights(points)
