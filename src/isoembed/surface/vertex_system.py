"""Sparse matrices J^T J + S + w P over the vertices: Hessians of stretching energies with penalties.

J is the rigidity matrix (`isoembed.surface.rigidity`).
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from isoembed.arrays import Floats, Indices
from isoembed.linalg import SymmetricFactor, Work, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity_matrix import MEAN_DIAGONAL

DIAGONAL_SHIFT = 1e-10  # relative, added to J^T J: it fixes the rigid motions


class HeldVertices(NamedTuple):
    """Constrained vertices.

    Attributes
    ----------
    corners : ndarray of int, shape (n,)
    blocks : ndarray, shape (n, 3, 3)
        Penalty added to the diagonal block of each.
    """

    corners: Indices
    blocks: Floats

    @classmethod
    def fixed(cls, corners: Indices) -> HeldVertices:
        """Fixed vertices: they move by at most 1e-20 times a force."""
        return cls(corners, np.tile(1e20 * np.eye(3), (len(corners), 1, 1)))


class HeldTriangle(HeldVertices):
    """Triangle whose constraints remove exactly the six rigid motions.

    The first corner is fixed, the second moves only along the edge to it, the third only in the plane.
    """

    @classmethod
    def of(cls, vertices: Floats, corners: Indices) -> HeldTriangle:
        """Hold the triangle with these corners."""
        x, y, z = vertices[corners]
        along, normal = y - x, np.cross(y - x, z - x)
        along, normal = along / np.linalg.norm(along), normal / np.linalg.norm(normal)
        across = np.eye(3) - np.outer(along, along)
        return cls(corners, MEAN_DIAGONAL * np.array([np.eye(3), across, np.outer(normal, normal)]))


class VertexSystem:
    """Matrices ``J^T J + S + w P`` of one triangulation with a penalty P.

    Parameters
    ----------
    triangulation : Triangulation
    penalty : sparse, shape (V, V), optional
        P, symmetric; its pattern, with the triangulation's, is the pattern of every matrix of the system.
        It acts on x, y and z alike.
    work : Work, optional
        Counter of factorizations.
    """

    def __init__(
        self, triangulation: Triangulation, penalty: csr_array | None = None, work: Work | None = None
    ) -> None:
        self.triangulation = triangulation
        n = triangulation.n_vertices
        penalty = csr_array((n, n)) if penalty is None else penalty
        graph = csr_array(triangulation.adjacency + abs(penalty) + eye_array(n))
        graph.data[:] = 1.0  # the pattern must not depend on cancellation of values
        pairs = csr_array(graph - eye_array(n))
        pairs.eliminate_zeros()
        order = dissect(pairs).block_order(3)  # where P reaches beyond the neighbors, so do the separators
        blocks = kron(graph, np.ones((3, 3)), format="bsr")
        self._solver = analyze(blocks.tocsr().T, order, work=work)  # symmetric
        pattern = self._solver.pattern
        column = np.repeat(np.arange(3 * n), np.diff(pattern.indptr))
        self._keys = column * (3 * n) + pattern.indices
        a, b = triangulation.edges.T
        # The four 3 x 3 blocks of an edge: +R at (a, a) and (b, b), -R at (a, b) and (b, a).
        self._edge_slots = np.concatenate([self._blocks(i, j) for i, j in ((a, a), (b, b), (a, b), (b, a))])
        self._edge_signs = np.repeat([1.0, 1.0, -1.0, -1.0], 9 * len(a))
        self._vertex_slots = self._blocks(np.arange(n), np.arange(n))
        entries = penalty.tocoo()
        slots = [self._slot(3 * entries.row + k, 3 * entries.col + k) for k in range(3)]
        values = np.tile(entries.data, 3)
        self._penalty = cast(Floats, np.bincount(np.concatenate(slots), values, minlength=len(self._keys)))
        self._diagonal = pattern.indices == column
        self._hold = DIAGONAL_SHIFT * MEAN_DIAGONAL * self._diagonal

    def _slot(self, row: Indices, column: Indices) -> Indices:
        return np.searchsorted(
            self._keys, column.astype(np.int64) * (3 * self.triangulation.n_vertices) + row
        )

    def _blocks(self, a: Indices, b: Indices) -> Indices:
        i, j = np.divmod(np.arange(9), 3)
        return self._slot(3 * a[:, None] + i, 3 * b[:, None] + j).ravel()

    def penalized(
        self,
        rows: Floats,
        weight: float,
        surface: Projected | None = None,
        tensions: Floats | float = 0.0,
        clamped: HeldVertices | None = None,
    ) -> SymmetricFactor:
        """Factor ``J^T J + S + weight P``, J given by its `edge_rows`; raises SingularMatrix if not definite.

        S is the Laplacian of the triangulation with the tensions, (E,), as edge weights.  For a surface in
        hyperbolic or spherical space P penalizes the motions ``w z`` of its points.  Rigid motions are
        suppressed by a small diagonal shift or by held vertices, which are needed for weights below
        `DIAGONAL_SHIFT`, where the shift would exceed P.
        """
        penalty = weight * self._penalty
        if surface is not None and not surface.space.is_euclidean:
            pattern, w = self._solver.pattern, np.repeat(surface.heights, 3)
            penalty *= w[pattern.indices] * np.repeat(w, np.diff(pattern.indptr))
        hold = self._hold
        if clamped is not None:
            hold = 1e-16 / DIAGONAL_SHIFT * hold  # with held vertices, a shift of 1e-16 suffices
            hold[self._vertex_slots.reshape(-1, 9)[clamped.corners]] += clamped.blocks.reshape(-1, 9)
        return self._factor(rows, penalty, tensions, hold)

    def damped(self, rows: Floats, damping: float) -> SymmetricFactor:
        """Factor ``J^T J + damping I``, J given by its `edge_rows`."""
        none = np.zeros(len(self._keys))
        return self._factor(rows, none, 0.0, damping * self._diagonal)

    def spherical_step(self, vertices: Floats, rows: Floats, residuals: Floats, radius: float) -> Floats:
        """Gauss-Newton step, (V, 3), for the lengths and ``|x_a| = r``, to subtract from the vertices.

        The rows ``x_a^T / r`` with residuals ``(|x_a|^2 - r^2) / (2 r)`` are appended to those of J, given by
        its `edge_rows`.  Raises SingularMatrix if the matrix is not positive definite.
        """
        outward = vertices / radius
        blocks = np.einsum("ai,aj->aij", outward, outward).ravel()
        extra = cast(Floats, np.bincount(self._vertex_slots, blocks, minlength=len(self._keys)))
        heights = radius * (np.einsum("ai,ai->a", outward, outward) - 1) / 2
        gradient = self.triangulation.incidence @ (rows * residuals[:, None]) + outward * heights[:, None]
        return self._factor(rows, extra, 0.0, self._hold).solve(gradient.ravel(), sweeps=1).reshape(-1, 3)

    def _factor(self, rows: Floats, extra: Floats, tensions: Floats | float, hold: Floats) -> SymmetricFactor:
        products = (np.einsum("ei,ej->eij", rows, rows) + np.multiply.outer(tensions, np.eye(3))).ravel()
        values = np.bincount(
            self._edge_slots, self._edge_signs * np.tile(products, 4), minlength=len(self._keys)
        )
        return self._solver.factor(values + extra + hold)
