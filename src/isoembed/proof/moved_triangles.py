"""Bounds on angles, areas and crossings of triangles whose corners move.

A motion of the corners by d_a is linear on the triangle, ``p + L p``, ``L = sum of d_a grad lambda_a``, where
the gradients of the barycentric coordinates lambda have the norms 1 / h_a, h being the triangle's heights.
With ``|L| <= Lambda < 1`` the normal turns by no more than ``-log(1 - Lambda)`` on the straight way: its rate
at the time t is ``|L| / (1 - t |L|)`` at most.  A dihedral angle turns by no more than both normals do.

If the squared lengths change by q_ij, the metric of the triangle changes by

    G = -sum of q_ij sym(grad lambda_i grad lambda_j),

and its area becomes ``det(1 + G)^(1/2)`` times what it was.  This determinant is ``1 + tr G``, up to |G|^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.proof.length_equations import NotProven
from isoembed.proof.rounding import GUARD, U
from isoembed.surface.curvature import SHUT, dihedral_angles
from isoembed.surface.measures import face_areas


@dataclass(frozen=True, eq=False)
class MovedTriangles:
    """Triangles, and how far their corners move: by steps, and by d with ``sum of |d_a / share_a|^2 <= r^2``.

    Attributes
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    steps : ndarray, shape (V,)
        Upper bounds.
    shares : ndarray, shape (V,)
    radius : float
        r.
    """

    triangulation: Triangulation
    vertices: Floats
    steps: Floats
    shares: Floats
    radius: float

    @cached_property
    def far(self) -> Floats:
        """Bound on the motion of each vertex, (V,)."""
        return GUARD * (self.steps + self.radius * self.shares)

    @cached_property
    def areas(self) -> Floats:
        """Areas of the triangles, rounded, (F,)."""
        return face_areas(self.triangulation.faces, self.vertices)

    @cached_property
    def rounding(self) -> Floats:
        """Bounds on relative errors of the areas by rounding, and on radians of the normals, (F,)."""
        sizes = np.sort(np.linalg.norm(self._sides, axis=2), axis=1)
        with np.errstate(divide="ignore"):
            found = 16 * U * sizes[:, 1] * sizes[:, 2] / (2 * self.areas)
        if not (found < SHUT).all():
            f = int(np.argmax(found))
            raise NotProven(f"face {f} {self.triangulation.faces[f].tolist()} is too low for floats")
        return found

    @cached_property
    def _sides(self) -> Floats:
        """The sides of the triangles, each across from its corner, (F, 3, 3)."""
        x, faces = self.vertices, self.triangulation.faces
        return x[np.roll(faces, 1, axis=1)] - x[np.roll(faces, -1, axis=1)]

    @cached_property
    def gradients(self) -> Floats:
        """Gradients of the barycentric coordinates, turned by a right angle in the triangle, (F, 3, 3)."""
        low = 2 * self.areas * (1 - self.rounding)
        return self._sides / low[:, None, None]

    @cached_property
    def softness(self) -> Floats:
        """Bound on the stretch of a triangle by d, over its ``(sum of |d_a / share_a|^2)^(1/2)``, (F,)."""
        shares = self.shares[self.triangulation.faces]
        return GUARD * np.linalg.norm(self.gradients * shares[:, :, None], 2, axis=(1, 2))

    @cached_property
    def stretched_by_steps(self) -> Floats:
        """The part of `stretch` that is due to the steps, (F,)."""
        steps = self.steps[self.triangulation.faces]
        return GUARD * (np.linalg.norm(self.gradients, axis=2) * steps).sum(axis=1)

    @cached_property
    def stretch(self) -> Floats:
        """Lambda, (F,)."""
        return GUARD * (self.stretched_by_steps + self.radius * self.softness)

    @cached_property
    def turns(self) -> Floats:
        """Radians by which normals turn, and by which they are off as they are computed, (F,)."""
        known = self.stretch < 1
        turned = -np.log1p(-np.where(known, self.stretch, 0.0))
        return np.where(known, GUARD * turned + self.rounding, np.inf)

    @cached_property
    def dihedral_angles(self) -> Floats:
        """Dihedral angles for the vertices, rounded, (E,)."""
        return dihedral_angles(self.triangulation, self.vertices)

    @cached_property
    def bends(self) -> Floats:
        """Radians by which dihedral angles turn, (E,): those between -pi and pi may jump by 2 pi besides."""
        return GUARD * self.turns[self.triangulation.edge_faces].sum(axis=1) + 16 * U

    @cached_property
    def may_jump(self) -> Floats:
        """Edges whose dihedral angle may pass pi, (E,)."""
        left, right = self.triangulation.edge_faces.T
        shut = 2 * SHUT / (4 * self.areas[left] * self.areas[right])
        return np.abs(self.dihedral_angles) + self.bends >= np.pi - shut

    def area_changes(self, squares: Floats) -> Floats:
        """Bounds on the change of the area of each triangle, (F,), its rounding included.

        Parameters
        ----------
        squares : ndarray, shape (E,)
            Upper bounds on the changes of the squared lengths.
        """
        q = squares[self.triangulation.face_edges]  # from each corner to the next one
        ahead = np.roll(self.gradients, -1, axis=1)
        traces = np.abs(np.einsum("fij,fij->fi", self.gradients, ahead))
        norms = np.linalg.norm(self.gradients, axis=2) * np.linalg.norm(ahead, axis=2)
        change = (q * traces).sum(axis=1) + (q * norms).sum(axis=1) ** 2
        # The traces of right angles are rounding alone.
        change = GUARD * (change + 64 * U * (q * norms).sum(axis=1))
        known = change < 1
        root = np.sqrt(1 - np.where(known, change, 0.0))
        grown = np.where(known, change / (1 + root), np.inf)
        return GUARD * self.areas * (1 + self.rounding) * (grown + self.rounding)
