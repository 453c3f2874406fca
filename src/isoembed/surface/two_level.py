"""Two-level preconditioned conjugate gradients on J^T J, where memory lacks for a factorization.

The mesh is taken apart into aggregates of some thirty vertices.  On the coarse level these move as rigid
bodies, which changes only the edges between them: a matrix of six unknowns an aggregate, whose factors are a
tenth as large.  (Smoothed aggregation starts from the rigid motions, too: Vanek, Mandel, Brezina, Computing
56, 1996.  But its hierarchies take as much memory as the factors of J J^T.)  What the coarse level leaves is
smoothed by a polynomial in J^T J (Adams, Brezina, Hu, Tuminaro, J. Comput. Phys. 188, 2003).  On convex
surfaces the number of iterations does not grow with the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, csr_array, eye_array

from isoembed.arrays import Floats, Indices32
from isoembed.linalg import Dissection, SymmetricFactor, analyze, dissect
from isoembed.linalg.krylov import Approximation, conjugate_gradients
from isoembed.surface.rigidity_matrix import DIAGONAL_SHIFT, RigidityMatrix
from isoembed.surface.two_level_loops import (
    aggregates,
    coarse_blocks,
    diagonal_blocks,
    motions_of,
    take_away_rigid,
    times_blocks,
    wrenches_of,
)

MAX_AGGREGATE = 48  # vertices of a body of the coarse level
SMOOTHED = 2.0 / 30  # least eigenvalue of D^-1 J^T J that is smoothed


LARGEST = 2.0  # an edge couples two blocks: no eigenvalue of D^-1 J^T J is larger


class TwoLevel:
    """``J^T J + damping I`` and its preconditioner.

    Parameters
    ----------
    J : RigidityMatrix
    positions : ndarray, shape (V, 3)
        Where the vertices are in J.
    dissection : Dissection
        Of the vertex graph.
    damping : float

    Raises
    ------
    OutOfMemory
        Even the coarse matrix has factors that are too large.
    """

    def __init__(self, J: RigidityMatrix, positions: Floats, dissection: Dissection, damping: float) -> None:
        self._J, self._damping = J, damping
        self._arms = positions - positions.mean(axis=0)
        moments = self._arms.T @ self._arms
        self._turning = np.linalg.pinv(np.eye(3) * np.trace(moments) - moments)
        self._inverses = _inverses(J, damping)
        self._bodies = _Bodies.of(positions, aggregates(dissection.cells))
        self._coarse = self._bodies.factor(J, damping)

    def step(self, residuals: Floats, tolerance: float, most: int) -> Approximation:
        """Solve ``(J^T J + damping I) d = J^T r`` for d, (V, 3), orthogonal to the rigid motions.

        The tolerance is that of the equation's residual, relative to ``J^T r``; the most, of iterations.
        """
        return conjugate_gradients(
            self._times, self._preconditioned, self._J.forces(residuals), tolerance, most
        )

    def _times(self, motion: Floats) -> Floats:
        forces = self._J.forces(self._J.rates(motion))
        if self._damping:
            forces += self._damping * motion
        return forces

    def _preconditioned(self, forces: Floats) -> Floats:
        """A symmetric cycle: smooth, correct on the coarse level, smooth."""
        motion = self._smoothed(forces)
        motion += self._bodies.moved(self._coarse, forces - self._times(motion))
        motion += self._smoothed(forces - self._times(motion))
        take_away_rigid(motion, self._arms, self._turning)
        return motion

    def _smoothed(self, forces: Floats) -> Floats:
        """Chebyshev's iteration from zero for the eigenvalues from `SMOOTHED` to LARGEST.

        Source: Saad, Iterative methods for sparse linear systems, 2003, algorithm 12.1.
        """
        theta, delta = (LARGEST + SMOOTHED) / 2, (LARGEST - SMOOTHED) / 2
        sigma = theta / delta
        rho = 1 / sigma
        left = forces.copy()
        step = times_blocks(self._inverses, left) / theta
        motion = step.copy()
        for _ in range(3):  # Chebyshev polynomial of degree 4 in J^T J
            left -= self._times(step)
            before, rho = rho, 1 / (2 * sigma - rho)
            step *= rho * before
            step += 2 * rho / delta * times_blocks(self._inverses, left)
            motion += step
        return motion


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Aggregates of vertices that move as rigid bodies: three translations, three rotations each.

    Attributes
    ----------
    of_vertex : ndarray of int32, shape (V,)
    arms : ndarray, shape (V, 3)
        From the center of the body, over the size of them all: rotations then are as large as translations.
    together : ndarray, shape (6 count, 6)
        The motions of all bodies as one, an orthonormal basis.
    """

    of_vertex: Indices32
    arms: Floats
    together: Floats

    @classmethod
    def of(cls, positions: Floats, of_vertex: Indices32) -> _Bodies:
        sums = np.column_stack([np.bincount(of_vertex, x) for x in positions.T])
        centers = sums / np.bincount(of_vertex)[:, None]
        arms = positions - centers[of_vertex]
        size = float(np.sqrt(np.mean(np.einsum("ij,ij->i", arms, arms))))
        together = np.zeros((len(centers), 6, 6))
        together[:, :3, :3] = np.eye(3)
        together[:, 3:, 3:] = size * np.eye(3)
        for k, axis in enumerate(np.eye(3)):
            together[:, :3, 3 + k] = np.cross(axis, centers - centers.mean(axis=0))
        return cls(of_vertex, arms / size, np.linalg.qr(together.reshape(-1, 6))[0])

    @property
    def count(self) -> int:
        return len(self.together) // 6

    def factor(self, J: RigidityMatrix, damping: float) -> SymmetricFactor:
        """Factor the coarse matrix; raises OutOfMemory."""
        ends = self.of_vertex[J.ends]
        ends = ends[ends[:, 0] != ends[:, 1]]
        pairs = np.concatenate([ends, ends[:, ::-1]]).T
        graph = csr_array((np.ones(len(ends) * 2), (pairs[0], pairs[1])), shape=(self.count, self.count))
        pattern = csr_array(graph + eye_array(self.count))
        pattern.sort_indices()
        indptr, indices = pattern.indptr.astype(np.int32), pattern.indices.astype(np.int32)
        blocks = coarse_blocks(J.ends, J.rows, self.of_vertex, self.arms, indptr, indices, damping)
        matrix = bsr_array((blocks, indices, indptr), shape=(6 * self.count, 6 * self.count)).tocsr()
        matrix.setdiag(matrix.diagonal() + DIAGONAL_SHIFT * matrix.diagonal().mean())
        solver = analyze(matrix.T, dissect(graph).block_order(6))  # rows are columns: it is symmetric
        return solver.factor(matrix.data)

    def moved(self, factor: SymmetricFactor, forces: Floats) -> Floats:
        """How the vertices move with the bodies that these forces, (V, 3), act on."""
        wrenches = wrenches_of(self.of_vertex, self.arms, self.count, forces).ravel()
        moved = self._apart(factor.solve(self._apart(wrenches), sweeps=0))
        return motions_of(self.of_vertex, self.arms, moved.reshape(-1, 6))

    def _apart(self, vector: Floats) -> Floats:
        """Take away the motion as one, which the factor would blow up from rounding."""
        return vector - self.together @ (self.together.T @ vector)


def _inverses(J: RigidityMatrix, damping: float) -> Floats:
    """The inverses of the diagonal blocks of ``J^T J + damping I``, (V, 3, 3), held at flat vertices."""
    blocks = diagonal_blocks(J.ends, J.rows, J.vertices)
    trace = np.einsum("iaa->i", blocks)
    blocks[:, np.arange(3), np.arange(3)] += (damping + DIAGONAL_SHIFT * trace)[:, None]
    inverses = np.linalg.inv(blocks)
    return (inverses + inverses.transpose(0, 2, 1)) / 2
