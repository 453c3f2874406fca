"""Rigidity of interpolated surfaces: how edges within cells change with the values that are interpolated.

The surface is ``P z``, z the values of the chosen vertices.  Of each cell some edges are measured: those
inside or, if there are few, all that it has a part in.  Their ends are interpolated from the cell's stencil,
so that the products of their rows are one dense matrix a cell.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, csr_array, kron

from isoembed.arrays import Floats, Indices
from isoembed.kernel import kernel
from isoembed.linalg import Solver, SymmetricFactor, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.interpolation import CellRows, Stencils

MAX_EDGES = 30  # measured in a cell: an interpolated surface has fewer degrees of freedom
DIAGONAL_SHIFT = 1e-6  # relative: beyond rounding in single precision


class InterpolatedRigidity:
    """Edges within cells, as functions of the chosen vertices' values.

    Parameters
    ----------
    triangulation : Triangulation
        Of all vertices.
    stencils : Stencils

    Attributes
    ----------
    edges : ndarray of int, shape (M,)
        Those measured, cell by cell; on the border of small cells some twice.
    of_edge : ndarray of int, shape (M,)
        Their cells.
    """

    def __init__(self, triangulation: Triangulation, stencils: Stencils) -> None:
        self._triangulation, self._stencils = triangulation, stencils
        cells = stencils.cells.of_vertex[triangulation.edges]
        inner = np.flatnonzero(cells[:, 0] == cells[:, 1])
        # too few edges inside: those across the border are measured, too
        few = np.bincount(cells[inner, 0], minlength=len(stencils.cells.vertices)) < 6
        across = [np.flatnonzero((cells[:, 0] != cells[:, 1]) & few[cells[:, end]]) for end in (0, 1)]
        edges = np.concatenate([inner, *across])
        of_edge = np.concatenate([cells[inner, 0], cells[across[0], 0], cells[across[1], 1]])
        order = np.argsort(of_edge, kind="stable")
        edges, of_edge = edges[order], of_edge[order]
        counts = np.bincount(of_edge, minlength=len(few))
        rank = np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts)
        # Every so many, so that few enough are left: where a whole number of shares is passed.
        of, most = counts[of_edge], MAX_EDGES
        kept = (of <= most) | ((rank + 1) * most // of > rank * most // of)
        self.edges, self.of_edge = edges[kept], of_edge[kept]

    def differences(self, positions: Floats) -> CellRows:
        """The differences of both ends of the edges, (M, C), interpolated in charts of these positions."""
        ends = self._triangulation.edges[self.edges]
        n = len(self._stencils.cells.vertices)
        pairs, places = np.unique(ends * n + self.of_edge[:, None], return_inverse=True)
        P = self._stencils.interpolation(positions, self._triangulation.faces, pairs // n, pairs % n)
        first, second = (P[place] for place in places.reshape(ends.shape).T)
        first.data = first.data - second.data  # of one stencil
        return CellRows.of(self._stencils, first, self.of_edge)

    @cached_property
    def pattern(self) -> csc_array:
        """Which of the chosen vertices are coupled, (C, C)."""
        stencils = self._stencils.pattern
        products = csc_array(stencils.T @ stencils)
        products.sort_indices()
        ones = np.ones(products.nnz, dtype=np.int8)
        return csc_array((ones, products.indices, products.indptr), shape=products.shape)

    @cached_property
    def _solver(self) -> Solver:
        order = dissect(csr_array(self.pattern)).block_order(3)
        return analyze(kron(self.pattern, np.ones((3, 3), dtype=np.int8), format="csc"), order)

    def factor(self, differences: CellRows, rows: Floats, penalty: csr_array) -> SymmetricFactor:
        """Factor ``(J P)^T J P + penalty``, in single precision, the penalty acting on x, y and z alike.

        Parameters
        ----------
        differences : CellRows, (M, C)
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
        pattern = self.pattern
        values = np.zeros(9 * pattern.nnz)
        _add_products(
            differences.starts,
            differences.stencils,
            differences.weights,
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
        values[diagonal] *= 1 + DIAGONAL_SHIFT
        return self._solver.factor(values, single=True)


@kernel
def _add_products(
    starts: Indices,
    stencils: tuple[Indices, Indices],
    differences: Floats,
    rows: Floats,
    pattern: tuple[Indices, Indices],
    values: Floats,
) -> None:
    """Add the products of the rows of each cell to the zeros of a symmetric matrix in blocks of 3 x 3.

    They are added up below the diagonal, then copied above it.
    """
    indptr, indices = pattern
    n = len(indptr) - 1
    diagonal = np.empty(n, dtype=np.int64)
    for column in range(n):
        p = indptr[column]
        while indices[p] < column:
            p += 1
        diagonal[column] = p
    at = 0  # in the differences
    for cell in range(len(starts) - 1):
        first, last = starts[cell], starts[cell + 1]
        begin = stencils[0][cell]
        size = stencils[0][cell + 1] - begin
        if first == last:
            continue
        J = np.empty((last - first, 3 * size), dtype=np.float32)
        for edge in range(first, last):
            for j in range(size):
                for k in range(3):
                    J[edge - first, 3 * j + k] = differences[at] * rows[edge, k]
                at += 1
        products = np.dot(J.T, J)
        for j in range(size):
            column = stencils[1][begin + j]
            start, p = indptr[column], diagonal[column]
            width = 3 * (indptr[column + 1] - start)
            for i in range(j, size):
                row = stencils[1][begin + i]
                while indices[p] < row:
                    p += 1
                place = 9 * start + 3 * (p - start)
                for b in range(3):
                    for a in range(3):
                        values[place + b * width + a] += products[3 * j + b, 3 * i + a]
    above = indptr[:-1].copy()  # the next block above the diagonal, by column
    for column in range(n):
        start, width = indptr[column], 3 * (indptr[column + 1] - indptr[column])
        for p in range(diagonal[column] + 1, indptr[column + 1]):
            row = indices[p]
            first, mirrored = indptr[row], 3 * (indptr[row + 1] - indptr[row])
            place = 9 * start + 3 * (p - start)
            image = 9 * first + 3 * (above[row] - first)
            above[row] += 1
            for b in range(3):
                for a in range(3):
                    values[image + a * mirrored + b] = values[place + b * width + a]
