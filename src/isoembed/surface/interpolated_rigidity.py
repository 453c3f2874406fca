"""Rigidity matrix of an interpolated surface.

The surface is ``P z``, where z are the positions of the coarse vertices.  In each cell some edges are
measured: those inside it or, if these are few, also those across its border.  Their ends are interpolated
from the cell's stencil, so that the products of their rows form one dense matrix per cell.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, csr_array, kron

from isoembed.arrays import Floats, Indices
from isoembed.linalg import Solver, SymmetricFactor, Work, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.interpolation import CellRows, Stencils
from isoembed.surface.interpolation_loops import add_cell_products, mirror_blocks, row_differences
from isoembed.threads import run_ranges

MAX_EDGES = 30  # measured edges per cell: an interpolated surface has fewer degrees of freedom
DIAGONAL_SHIFT = 1e-6  # relative: above the rounding error of single precision


class InterpolatedRigidity:
    """Edges within cells as functions of the coarse vertices' positions.

    Parameters
    ----------
    triangulation : Triangulation
        Fine triangulation, of all vertices.
    stencils : Stencils
    work : Work, optional
        Counter of factorizations.

    Attributes
    ----------
    edges : ndarray of int, shape (M,)
        Measured edges, cell by cell; some edges on the border of small cells appear twice.
    of_edge : ndarray of int, shape (M,)
        Cell of each measured edge.
    """

    def __init__(self, triangulation: Triangulation, stencils: Stencils, work: Work | None = None) -> None:
        self._triangulation, self._stencils, self._work = triangulation, stencils, work
        cells = stencils.cells.of_vertex[triangulation.edges]
        inner = np.flatnonzero(cells[:, 0] == cells[:, 1])
        # with too few edges inside, those across the border are measured, too
        few = np.bincount(cells[inner, 0], minlength=len(stencils.cells.vertices)) < 6
        across = [np.flatnonzero((cells[:, 0] != cells[:, 1]) & few[cells[:, end]]) for end in (0, 1)]
        edges = np.concatenate([inner, *across])
        of_edge = np.concatenate([cells[inner, 0], cells[across[0], 0], cells[across[1], 1]])
        order = np.argsort(of_edge, kind="stable")
        edges, of_edge = edges[order], of_edge[order]
        counts = np.bincount(of_edge, minlength=len(few))
        rank = np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts)
        # Evenly spaced subset of at most MAX_EDGES edges per cell.
        of, limit = counts[of_edge], MAX_EDGES
        sampled = (of <= limit) | ((rank + 1) * limit // of > rank * limit // of)
        self.edges, self.of_edge = edges[sampled], of_edge[sampled]

    def interpolated(self, positions: Floats) -> tuple[CellRows, CellRows]:
        """Interpolation of vertices, (V, C), and edge vectors, (M, C), in charts at these positions."""
        stencils, ends = self._stencils, self._triangulation.edges[self.edges]
        cell, n = stencils.cells.of_vertex, len(stencils.cells.vertices)
        across = cell[ends] != self.of_edge[:, None]  # ends outside the edge's cell
        pairs, which = np.unique((ends * n + self.of_edge[:, None])[across], return_inverse=True)
        order = np.argsort(cell, kind="stable")
        vertices = np.concatenate([order, pairs // n])
        source = np.concatenate([cell[order], pairs % n])
        P = stencils.interpolation(positions, self._triangulation.faces, vertices, source)
        places = np.argsort(order)[ends]
        places[across] = len(cell) + which
        differences = row_differences(P.indptr, P.data, places)
        every = np.arange(len(places))
        return (
            CellRows.of(stencils, P.data[: P.indptr[len(cell)]], order, cell[order]),
            CellRows.of(stencils, differences, every, self.of_edge),
        )

    @cached_property
    def pattern(self) -> csc_array:
        """Sparsity pattern of the coupling of the coarse vertices, (C, C)."""
        stencils = self._stencils.pattern
        products = csc_array(stencils.T @ stencils)
        products.sort_indices()
        ones = np.ones(products.nnz, dtype=np.int8)
        return csc_array((ones, products.indices, products.indptr), shape=products.shape)

    @cached_property
    def _solver(self) -> Solver:
        order = dissect(csr_array(self.pattern)).block_order(3)
        blocks = kron(self.pattern, np.ones((3, 3), dtype=np.int8), format="bsr")
        return analyze(blocks.tocsr().T, order, work=self._work)  # symmetric

    @cached_property
    def _keys(self) -> Indices:
        """A number for each entry of the pattern, by column and row, ascending."""
        n = self.pattern.shape[0]
        return np.repeat(np.arange(n), np.diff(self.pattern.indptr)) * n + self.pattern.indices

    @cached_property
    def _diagonal(self) -> Indices:
        """Places of the diagonal among the entries of the matrix."""
        pattern = self._solver.pattern
        columns = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
        return np.flatnonzero(pattern.indices == columns)

    def factor(self, differences: CellRows, rows: Floats, penalty: csr_array) -> SymmetricFactor:
        """Factor ``(J P)^T J P + penalty`` in single precision; the penalty acts on x, y and z alike.

        Parameters
        ----------
        differences : CellRows, (M, C)
            As from `interpolated`.
        rows : ndarray, shape (M, 3)
            Gradients of the residuals with respect to the edge vectors.
        penalty : sparse, shape (C, C)
            Symmetric matrix with its pattern contained in `pattern`.

        Raises
        ------
        SingularMatrix
            The matrix is not positive definite.
        """
        pattern = self.pattern
        values = self._products(differences, rows)
        coupled = csc_array(penalty).tocoo()
        at = np.searchsorted(self._keys, coupled.col.astype(np.int64) * pattern.shape[0] + coupled.row)
        first = pattern.indptr[coupled.col].astype(np.int64)
        width = 3 * (pattern.indptr[coupled.col + 1] - first)
        for k in range(3):
            values[9 * first + 3 * (at - first) + k * width + k] += coupled.data
        values[self._diagonal] *= 1 + DIAGONAL_SHIFT
        return self._solver.factor(values, single=True)

    def _products(self, differences: CellRows, rows: Floats) -> Floats:
        """Entries of ``(J P)^T J P``."""
        pattern = self.pattern
        values = np.zeros(9 * pattern.nnz)
        ends = pattern.shape[0] * np.arange(5) // 4  # four parts of the columns, for any number of threads

        def add(parts: range) -> None:
            for k in parts:
                add_cell_products(differences, rows, pattern, range(ends[k], ends[k + 1]), values)

        run_ranges(add, 4, 1)
        mirror_blocks(pattern, values)
        return values
