"""Smooth interpolation from coarse vertices by local quintic fits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolation_loops import products_of, projected, transposed_products
from isoembed.surface.local_fit import FitResiduals, edge_lengths_about, neighborhoods
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.normal_fits import THREE_RINGS

DEGREE = 5


@dataclass(frozen=True, eq=False)
class Stencils:
    """The chosen vertices whose values are used in each cell: three rings of triangles, and its own.

    Attributes
    ----------
    cells : VertexCells
    triangulation : Triangulation
        Of the chosen vertices.
    """

    cells: VertexCells
    triangulation: Triangulation

    @cached_property
    def pattern(self) -> csr_array:
        """The chosen vertices by cell, ascending, (C, C)."""
        n = self.triangulation.n_vertices
        adjacency = self.triangulation.adjacency
        indptr, indices = neighborhoods((adjacency.indptr, adjacency.indices), THREE_RINGS)
        around = csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n))
        pattern = csr_array(around + eye_array(n))
        pattern.sort_indices()
        return pattern

    def interpolation(self, positions: Floats, faces: Indices, vertices: Indices, cell: Indices) -> csr_array:
        """Weights of the chosen vertices' values in those of some vertices, shape (n, C).

        Parameters
        ----------
        positions : ndarray, shape (V, 3)
            Of a smooth surface, in whose tangent planes the polynomials are fitted.
        faces : ndarray of int, shape (F, 3)
            Of all its vertices.
        vertices : ndarray of int, shape (n,)
            Where values are wanted.
        cell : ndarray of int, shape (n,)
            Whose stencil each is interpolated from: that of its own cell, or of one that it borders on.
        """
        chosen = positions[self.cells.vertices]
        lengths = edge_lengths(self.triangulation.edges, chosen)
        units = edge_lengths_about(self.triangulation, lengths)
        weights = self.pattern[cell]
        stencils = weights.indptr, weights.indices
        normals = vertex_normals(faces, positions)[vertices]
        charts = projected(positions[vertices], normals, units[cell], chosen, weights.indptr, weights.indices)
        weights.data = FitResiduals.of(0, stencils, charts, DEGREE).weights
        return weights


@dataclass(frozen=True, eq=False)
class CellRows:
    """A matrix (n, C) whose rows, cell by cell, have entries at the stencil of their cell.

    Products with it are those of a small dense matrix a cell.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Their numbers, cell by cell.
    starts : ndarray of int, shape (C + 1,)
        Those of a cell are ``rows[starts[cell] : starts[cell + 1]]``.
    stencils : (indptr, indices)
        Of the cells.
    weights : ndarray, shape (nnz,)
        The entries, in this order.
    """

    rows: Indices
    starts: Indices
    stencils: tuple[Indices, Indices]
    weights: Floats

    @classmethod
    def of(cls, stencils: Stencils, weights: csr_array, cell: Indices) -> CellRows:
        """The rows of a matrix as from `Stencils.interpolation`, with the cell of each."""
        rows = np.argsort(cell, kind="stable")
        pattern = stencils.pattern
        starts = np.searchsorted(cell[rows], np.arange(pattern.shape[0] + 1))
        return cls(rows, starts, (pattern.indptr, pattern.indices), weights[rows].data)

    def __matmul__(self, values: Floats) -> Floats:
        """The products, (n, 3), with values (C, 3)."""
        return products_of(self.rows, self.starts, *self.stencils, self.weights, values)

    def transposed(self, forces: Floats) -> Floats:
        """The products, (C, 3), of the transposed matrix with forces (n, 3)."""
        return transposed_products(self.rows, self.starts, *self.stencils, self.weights, forces)
