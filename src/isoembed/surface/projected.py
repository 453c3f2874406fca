"""Rigidity in hyperbolic and spherical space through projective coordinates.

With y = x / w and motions x' = w z of the points, lengths change by

    dl_ab/dt = (w_a w_b / sn(l_ab)) (y_a - y_b) . (z_a - z_b):

the rigidity matrix of a surface in a space form is a Euclidean one with scaled rows (Pogorelov, Topics in the
theory of surfaces in elliptic space, 1961).  The isometries are ``z = p + q x y``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.space import Space


@dataclass(frozen=True, eq=False)
class Projected:
    """Projective coordinates of a surface's vertices (in R^3 the vertices themselves), and motions from z.

    Attributes
    ----------
    space : Space
    vertices : ndarray, shape (V, 3)
        x: the first three coordinates on hyperboloid or sphere.
    heights : ndarray, shape (V,)
        w.
    positions : ndarray, shape (V, 3)
        y.
    """

    space: Space
    vertices: Floats
    heights: Floats
    positions: Floats

    @classmethod
    def of(cls, space: Space, vertices: Floats) -> Projected:
        """Projective coordinates of vertices x, (V, 3)."""
        w = space.heights(vertices)
        return cls(space, vertices, w, vertices if space.is_euclidean else vertices / w[:, None])

    def divisors(self, edges: Indices | Indices32, lengths: Floats) -> Floats:
        """``sn(l_ab) / (w_a w_b)``, shape (E,): divisors of ``y_a - y_b`` in the rows of J."""
        if self.space.is_euclidean:
            return lengths
        a, b = edges.T
        return self.space.sn(lengths) / (self.heights[a] * self.heights[b])

    def motion(self, z: Floats) -> Floats:
        """Motions of x, (V, 3)."""
        return z if self.space.is_euclidean else self.heights[:, None] * z

    def velocities(self, z: Floats) -> Floats:
        """Motions translated to the origin, (V, 3): their norms are the speeds of the points."""
        if self.space.is_euclidean:
            return z
        return self.heights[:, None] * z + self._radial(z)

    def from_velocities(self, v: Floats) -> Floats:
        """The z of `velocities`, (V, 3)."""
        return v if self.space.is_euclidean else (v - self._radial(v)) / self.heights[:, None]

    def _radial(self, vectors: Floats) -> Floats:
        """``(1 - w) e (e . v)``, e = x / |x|."""
        x = self.vertices
        along = np.einsum("ij,ij->i", x, vectors) / (1 + self.heights)
        return self.space.curvature * along[:, None] * x

    def isometries(self) -> Floats:
        """Orthonormal basis of the `velocities` that change no length, shape (3 V, 6)."""
        return np.linalg.qr(np.column_stack([self.velocities(z).ravel() for z in self._rigid_motions()]))[0]

    def rigid_motions(self) -> Floats:
        """Orthonormal basis of the z that change no length, shape (3 V, 6)."""
        return np.linalg.qr(np.column_stack([z.ravel() for z in self._rigid_motions()]))[0]

    def without_isometries(self) -> Callable[[Floats], Floats]:
        """Projection of z, (3 V,), to the complement of the isometries."""
        basis = self.rigid_motions()
        return lambda z: z - basis @ (basis.T @ z)

    def _rigid_motions(self) -> list[Floats]:
        """Six z, (V, 3), that change no length."""
        fields = [np.broadcast_to(axis, self.positions.shape) for axis in np.eye(3)]
        return [*fields, *np.cross(np.eye(3)[:, None], self.positions)]
