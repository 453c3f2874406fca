"""Bounds on the changes of angles and areas of triangles whose corners move.

A motion of the corners by d_a is linear on the triangle, ``p + L p``, ``L = sum of d_a grad lambda_a``, where
the gradients of the barycentric coordinates lambda have norms 1 / h_a, with the triangle's heights h.  If
``|L| <= Lambda < 1``, the normal turns by at most ``-log(1 - Lambda)`` along the straight path: its rate at
time t is at most ``|L| / (1 - t |L|)``.  A dihedral angle changes by at most the sum for both normals.

If the squared lengths change by q_ij, the metric of the triangle changes by

    G = -sum of q_ij sym(grad lambda_i grad lambda_j),

and its area is multiplied by ``det(1 + G)^(1/2)``.  This determinant is ``1 + tr G``, up to |G|^2.
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
    """Triangles whose corners move by steps, and by d with ``sum of |d_a / share_a|^2 <= r^2``.

    Attributes
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    steps : ndarray, shape (V,)
        Upper bounds on the steps.
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
        """Bounds on rounding errors: relative ones of areas, and rotations of normals in radians, (F,)."""
        sizes = np.sort(np.linalg.norm(self._sides, axis=2), axis=1)
        with np.errstate(divide="ignore"):
            found = 16 * U * sizes[:, 1] * sizes[:, 2] / (2 * self.areas)
        if not (found < SHUT).all():
            f = int(np.argmax(found))
            raise NotProven(f"face {f} {self.triangulation.faces[f].tolist()} is too low for floats")
        return found

    @cached_property
    def _sides(self) -> Floats:
        """Sides of the triangles, each opposite to its corner, (F, 3, 3)."""
        x, faces = self.vertices, self.triangulation.faces
        return x[np.roll(faces, 1, axis=1)] - x[np.roll(faces, -1, axis=1)]

    @cached_property
    def gradients(self) -> Floats:
        """Gradients of the barycentric coordinates, rotated by a right angle in the triangle, (F, 3, 3)."""
        low = 2 * self.areas * (1 - self.rounding)
        return self._sides / low[:, None, None]

    @cached_property
    def softness(self) -> Floats:
        """Bound on the stretch of a triangle by d, relative to ``(sum of |d_a / share_a|^2)^(1/2)``, (F,)."""
        shares = self.shares[self.triangulation.faces]
        return GUARD * np.linalg.norm(self.gradients * shares[:, :, None], 2, axis=(1, 2))

    @cached_property
    def stretched_by_steps(self) -> Floats:
        """Part of `stretch` due to the steps, (F,)."""
        steps = self.steps[self.triangulation.faces]
        return GUARD * (np.linalg.norm(self.gradients, axis=2) * steps).sum(axis=1)

    @cached_property
    def stretch(self) -> Floats:
        """Bound Lambda on the linear maps of the triangles, (F,)."""
        return GUARD * (self.stretched_by_steps + self.radius * self.softness)

    @cached_property
    def turns(self) -> Floats:
        """Bounds on the rotation angles of normals, including rounding errors, in radians, (F,)."""
        valid = self.stretch < 1
        turned = -np.log1p(-np.where(valid, self.stretch, 0.0))
        return np.where(valid, GUARD * turned + self.rounding, np.inf)

    @cached_property
    def dihedral_angles(self) -> Floats:
        """Dihedral angles of the edges, computed from the vertices, (E,)."""
        return dihedral_angles(self.triangulation, self.vertices)

    @cached_property
    def bends(self) -> Floats:
        """Bounds on the changes of dihedral angles, in radians, modulo 2 pi, (E,)."""
        return GUARD * self.turns[self.triangulation.edge_faces].sum(axis=1) + 16 * U

    @cached_property
    def may_jump(self) -> Floats:
        """Edges whose dihedral angle may pass pi, (E,)."""
        left, right = self.triangulation.edge_faces.T
        shut = 2 * SHUT / (4 * self.areas[left] * self.areas[right])
        return np.abs(self.dihedral_angles) + self.bends >= np.pi - shut

    def area_changes(self, squares: Floats) -> Floats:
        """Bounds on the change of the area of each triangle, including rounding, (F,).

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
        # The traces for right angles are pure rounding error.
        change = GUARD * (change + 64 * U * (q * norms).sum(axis=1))
        valid = change < 1
        root = np.sqrt(1 - np.where(valid, change, 0.0))
        grown = np.where(valid, change / (1 + root), np.inf)
        return GUARD * self.areas * (1 + self.rounding) * (grown + self.rounding)
