"""Second-order Taylor expansion of the edge lengths in displacements of the vertices.

With displacements d of the vertices, the `length_residuals` are

    ``r + J d + 1/2 Q(d, d)``,  ``Q(v, w) = (v_a - v_b) . (w_a - w_b) / l_ab``,

exactly in Euclidean space.  In hyperbolic and spherical space sn(l) replaces l, and Q has
one more term.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths, edge_rows, length_residuals


@dataclass(frozen=True, eq=False)
class LengthExpansion:
    """Edge lengths near a surface, to second order.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
        Target lengths.
    """

    system: LengthSystem
    vertices: Floats
    lengths: Floats

    @cached_property
    def residuals(self) -> Floats:
        """r, shape (E,)."""
        return self.residuals_at(np.zeros_like(self.vertices))

    @cached_property
    def _linear(self) -> LinearizedLengths:
        return self.system.linearized(self.vertices, self.lengths)

    @cached_property
    def _surface(self) -> Projected:
        return Projected.of(self.system.space, self.vertices)

    def residuals_at(self, motion: Floats) -> Floats:
        """The `length_residuals`, (E,), after the motion d, (V, 3), to all orders."""
        moved = self.vertices + motion
        return length_residuals(self.system.triangulation, moved, self.lengths, self.system.space)

    def rates(self, motions: Floats) -> Floats:
        """``J d`` of motions, (m, V, 3): (m, E)."""
        triangulation, space = self.system.triangulation, self.system.space
        rows, (a, b) = edge_rows(triangulation, self.vertices, self.lengths, space), triangulation.edges.T
        z = motions if space.is_euclidean else motions / self._surface.heights[:, None]
        return np.asarray(np.einsum("ec,mec->me", rows, z[:, a] - z[:, b]))

    def motions(self, changes: Floats) -> Floats:
        """``J^+ dl`` of changes dl of the lengths, (m, E): (m, V, 3).

        The first call factors ``J J^T``.

        Raises
        ------
        SingularMatrix
            The surface is not infinitesimally rigid.
        OutOfMemory
            The factors need more memory than is free.
        """
        linear = self._linear
        tensions = linear.solve(np.ascontiguousarray(changes[:, linear.order].T)).T
        forces = [linear.J.forces(np.ascontiguousarray(each)) for each in tensions]
        return np.array([self._surface.motion(each) for each in forces])

    def bends(self, first: Floats, second: Floats) -> Floats:
        """``Q(v, w)`` of motions v and w, each (..., V, 3): (..., E)."""
        space, (a, b) = self.system.space, self.system.triangulation.edges.T
        products = np.einsum(
            "...ec,...ec->...e",
            first[..., a, :] - first[..., b, :],
            second[..., a, :] - second[..., b, :],
        )
        if not space.is_euclidean:
            products = products + self._bends_of_heights(first, second)
        return np.asarray(products / space.sn(self.lengths))

    def _bends_of_heights(self, first: Floats, second: Floats) -> Floats:
        """Contribution of the hyperboloid or sphere: half the second derivatives of w, squared, over k."""
        k, w, x = self.system.space.curvature, self._surface.heights, self.vertices
        a, b = self.system.triangulation.edges.T
        # w changes by -k times the slopes.
        slopes = [np.einsum("vc,...vc->...v", x, v) / w for v in (first, second)]
        bent = (np.einsum("...vc,...vc->...v", first, second) + k * slopes[0] * slopes[1]) / w
        change = [slope[..., a] - slope[..., b] for slope in slopes]
        return np.asarray(k * change[0] * change[1] - (w[a] - w[b]) * (bent[..., a] - bent[..., b]))
