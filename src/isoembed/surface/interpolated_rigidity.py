"""Rigidity of interpolated surfaces: how edges within cells change with the values that are interpolated.

The surface is ``P z``, z the values of the chosen vertices.  Of each cell some edges are measured whose ends
both belong to it: they share a stencil, so that the products of their rows are one dense matrix a cell.
"""

from __future__ import annotations

from functools import cached_property
from typing import cast

import numpy as np
from scipy.sparse import csc_array, csr_array, kron

from isoembed.arrays import Floats, Indices
from isoembed.kernel import kernel
from isoembed.linalg import Solver, SymmetricFactor, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.interpolation import Stencils
from isoembed.surface.rigidity_matrix import RIGIDITY


class InterpolatedRigidity:
    """Edges within cells, as functions of the chosen vertices' values.

    Parameters
    ----------
    triangulation : Triangulation
        Of all vertices.
    stencils : Stencils
    most : int
        Edges of a cell that are measured.

    Attributes
    ----------
    edges : ndarray of int, shape (M,)
        Those measured, cell by cell.
    of_edge : ndarray of int, shape (M,)
        Their cells.
    """

    def __init__(self, triangulation: Triangulation, stencils: Stencils, most: int) -> None:
        self._triangulation, self._stencils = triangulation, stencils
        cells = stencils.cells.of_vertex[triangulation.edges]
        inner = np.flatnonzero(cells[:, 0] == cells[:, 1])
        inner = inner[np.argsort(cells[inner, 0], kind="stable")]
        counts = np.bincount(cells[inner, 0], minlength=len(stencils.cells.vertices))
        rank = np.arange(len(inner)) - np.repeat(np.cumsum(counts) - counts, counts)
        # Every so many, so that `most` are left: where the number of the next one is a new whole number.
        share = np.minimum(most / np.maximum(np.repeat(counts, counts), 1), 1.0)
        self.edges = inner[np.floor((rank + 1) * share) > np.floor(rank * share)]
        self.of_edge = cells[self.edges, 0]
        self._starts = np.searchsorted(self.of_edge, np.arange(len(counts) + 1))

    def differences(self, positions: Floats) -> csr_array:
        """The differences of both ends of the edges, (M, C), interpolated in charts of these positions."""
        ends = self._triangulation.edges[self.edges]
        vertices, places = np.unique(ends, return_inverse=True)
        P = self._stencils.interpolation(positions, self._triangulation.faces, vertices)
        first, second = (P[place] for place in places.reshape(ends.shape).T)
        first.data = first.data - second.data  # of one stencil
        return first

    @cached_property
    def pattern(self) -> csc_array:
        """Which of the chosen vertices are coupled, (C, C)."""
        stencils = self._stencils.pattern
        pattern = csc_array(stencils.T @ stencils)
        pattern.data[:] = 1.0
        pattern.sort_indices()
        return pattern

    @cached_property
    def _solver(self) -> Solver:
        order = dissect(csr_array(self.pattern)).block_order(3)
        return analyze(kron(self.pattern, np.ones((3, 3)), format="csc"), order)

    def factor(self, differences: csr_array, rows: Floats, penalty: csr_array) -> SymmetricFactor:
        """Factor ``(J P)^T J P + penalty``, the penalty (C, C) acting on x, y and z alike.

        Parameters
        ----------
        differences : sparse, shape (M, C)
            From the method of this name.
        rows : ndarray, shape (M, 3)
            The gradients of the residuals by the differences.
        penalty : sparse, shape (C, C)
            Symmetric; couples no more than `pattern`.

        Raises
        ------
        SingularMatrix
            It is not positive definite.
        """
        pattern, stencils = self.pattern, self._stencils.pattern
        values = np.zeros(9 * pattern.nnz)
        _add_products(
            self._starts,
            (stencils.indptr, stencils.indices),
            differences.data,
            rows,
            (pattern.indptr, pattern.indices),
            values,
        )
        coupled = csc_array(penalty).tocoo()
        n = pattern.shape[0]
        keys = np.repeat(np.arange(n), np.diff(pattern.indptr)) * n + pattern.indices
        at = np.searchsorted(keys, coupled.col.astype(np.int64) * n + coupled.row)
        first = pattern.indptr[coupled.col].astype(np.int64)
        width = 3 * (pattern.indptr[coupled.col + 1] - first)
        for k in range(3):
            values[9 * first + 3 * (at - first) + k * width + k] += coupled.data
        diagonal = self._solver.pattern.indices == np.repeat(
            np.arange(3 * n), np.diff(self._solver.pattern.indptr)
        )
        values[diagonal] *= 1 + RIGIDITY.hold
        return self._solver.factor(values)


def edge_vectors(differences: csr_array, values: Floats) -> Floats:
    """The differences of interpolated values (C, 3), (M, 3)."""
    return cast(Floats, differences @ values)


@kernel
def _add_products(
    starts: Indices,
    stencils: tuple[Indices, Indices],
    differences: Floats,
    rows: Floats,
    pattern: tuple[Indices, Indices],
    values: Floats,
) -> None:
    """Add the products of the rows of each cell to the entries of a matrix in blocks of 3 x 3."""
    at = 0  # in the differences
    for cell in range(len(starts) - 1):
        first, last = starts[cell], starts[cell + 1]
        begin = stencils[0][cell]
        size = stencils[0][cell + 1] - begin
        if first == last:
            continue
        J = np.empty((last - first, 3 * size))
        for edge in range(first, last):
            for j in range(size):
                for k in range(3):
                    J[edge - first, 3 * j + k] = differences[at] * rows[edge, k]
                at += 1
        products = np.dot(J.T, J)
        for j in range(size):
            column = stencils[1][begin + j]
            start = pattern[0][column]
            width = 3 * (pattern[0][column + 1] - start)
            p = start
            for i in range(size):
                row = stencils[1][begin + i]
                while pattern[1][p] < row:
                    p += 1
                place = 9 * start + 3 * (p - start)
                for b in range(3):
                    for a in range(3):
                        values[place + b * width + a] += products[3 * i + a, 3 * j + b]
