"""Smooth interpolation from coarse vertices by local quintic fits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolation_loops import add_transposed_cells, multiply_cells, projected
from isoembed.surface.local_fit import FitResiduals, edge_lengths_about, neighborhoods
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.normal_fits import THREE_RINGS
from isoembed.threads import run_ranges

DEGREE = 5
CELLS = 250  # products with fewer take less time than starting a thread


@dataclass(frozen=True, eq=False)
class Stencils:
    """Interpolation stencils: the coarse vertex of each cell and those within three rings around it.

    Attributes
    ----------
    cells : VertexCells
    triangulation : Triangulation
        Coarse triangulation, of the cells' vertices.
    """

    cells: VertexCells
    triangulation: Triangulation

    @cached_property
    def pattern(self) -> csr_array:
        """Coarse vertices in the stencil of each cell, ascending, (C, C)."""
        n = self.triangulation.n_vertices
        adjacency = self.triangulation.adjacency
        indptr, indices = neighborhoods((adjacency.indptr, adjacency.indices), THREE_RINGS)
        around = csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n))
        pattern = csr_array(around + eye_array(n))
        pattern.sort_indices()
        return pattern

    def interpolation(self, positions: Floats, faces: Indices, vertices: Indices, cell: Indices) -> csr_array:
        """Interpolation weights of the coarse vertices at some fine vertices, shape (n, C).

        Parameters
        ----------
        positions : ndarray, shape (V, 3)
            Vertices of a smooth surface, in whose tangent planes the polynomials are fitted.
        faces : ndarray of int, shape (F, 3)
            Fine triangles.
        vertices : ndarray of int, shape (n,)
            Vertices to interpolate at.
        cell : ndarray of int, shape (n,)
            Cell whose stencil is used for each: its own or an adjacent one.
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
    """Matrix (n, C) in which the nonzeros of a row are those of its cell's stencil.

    Products with it are computed with one small dense matrix per cell.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Row indices, grouped by cell.
    starts : ndarray of int, shape (C + 1,)
        Row pointers: the rows of a cell are ``rows[starts[cell] : starts[cell + 1]]``.
    stencils : (indptr, indices)
        Stencils of the cells.
    weights : ndarray, shape (nnz,)
        Entries, in this order.
    """

    rows: Indices
    starts: Indices
    stencils: tuple[Indices, Indices]
    weights: Floats

    @classmethod
    def of(cls, stencils: Stencils, weights: Floats, rows: Indices, cell: Indices) -> CellRows:
        """Rows with these indices, of cells in ascending order."""
        pattern = stencils.pattern
        starts = np.searchsorted(cell, np.arange(pattern.shape[0] + 1))
        return cls(rows, starts, (pattern.indptr, pattern.indices), weights)

    @cached_property
    def offsets(self) -> Indices:
        """Index of the first weight of each cell, (C + 1,)."""
        return np.concatenate(([0], np.cumsum(np.diff(self.starts) * np.diff(self.stencils[0]))))

    def __matmul__(self, values: Floats) -> Floats:
        """Product with values (C, 3), (n, 3)."""
        products = np.empty((len(self.rows), 3))
        run_ranges(lambda cells: multiply_cells(self, cells, values, products), len(self.starts) - 1, CELLS)
        return products

    def transposed(self, forces: Floats) -> Floats:
        """Product of the transposed matrix with forces (n, 3), (C, 3)."""
        count = len(self.starts) - 1
        parts = range(1 if count < 4 * CELLS else 4)  # for any number of threads: the same sums
        products = np.zeros((len(parts), count, 3))

        def add(some: range) -> None:
            for part in some:
                cells = range(count * part // len(parts), count * (part + 1) // len(parts))
                add_transposed_cells(self, cells, forces, products[part])

        run_ranges(add, len(parts), 1)
        return products.sum(axis=0) if len(parts) > 1 else products[0]
