"""Edges of a patch: residuals of their lengths, and their terms in the gradient and Hessian of the energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats, Indices


@dataclass(frozen=True, eq=False)
class PatchEdges:
    """Edges with ends among the n vertices of a patch.

    Attributes
    ----------
    ends : ndarray of int, shape (m, 2)
        Indices among the vertices of the patch; n for fixed vertices.
    lengths : ndarray, shape (m,)
    n : int
    """

    ends: Indices
    lengths: Floats
    n: int

    def errors(self, vectors: Floats) -> tuple[Floats, Floats]:
        """The errors r of the edges along vectors, (m, 3), and their rows of J."""
        squares = np.einsum("ei,ei->e", vectors, vectors)
        return (squares - self.lengths**2) / (2 * self.lengths), vectors / self.lengths[:, None]

    def forces(self, rows: Floats, errors: Floats) -> Floats:
        """``J^T r``, (n, 3)."""
        pulls = rows * errors[:, None]
        both, at = np.concatenate([pulls, -pulls]), self.ends.T.ravel()
        return np.stack([np.bincount(at, each, minlength=self.n)[: self.n] for each in both.T], axis=1)

    def hessian(self, rows: Floats, tensions: Floats | float = 0.0) -> Floats:
        """``J^T J + S``, (3n, 3n), S the Laplacian with the tensions, (m,), as edge weights."""
        blocks = rows[:, :, None] * rows[:, None, :] + np.multiply.outer(tensions, np.eye(3))
        values, size = np.concatenate([blocks, blocks, -blocks, -blocks]).ravel(), 3 * self.n + 3
        matrix = np.bincount(self._slots, values, minlength=size**2).reshape(size, size)
        return np.asarray(matrix[:-3, :-3])  # fixed vertices share a block

    @cached_property
    def _slots(self) -> Indices:
        """Positions of the 3 x 3 blocks of the edges in the matrix, 36 entries for each edge."""
        of = 3 * self.ends.T[:, :, None] + np.arange(3)
        return (of[[0, 1, 0, 1], :, :, None] * (3 * self.n + 3) + of[[0, 1, 1, 0], :, None]).ravel()
