"""Matrix-free products with the rigidity matrix J, and assembly of J J^T.

A row of J per edge holds ``(x_a - x_b)^T / l_ab`` at a and its negative at b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32
from isoembed.linalg.memory import OutOfMemory, require_memory
from isoembed.surface.rigidity_loops import couplings, edge_rows, gram_values, length_rates, vertex_forces

MEAN_DIAGONAL = 2.0  # of J J^T, whose rows have unit norm at each end, and approximately of J^T J


@dataclass(frozen=True, eq=False)
class RigidityMatrix:
    """J of one surface.

    Attributes
    ----------
    ends : ndarray of int32, shape (E, 2)
        The vertices a and b of each edge.
    rows : ndarray, shape (E, 3)
        ``(x_a - x_b) / l_ab``.
    vertices : int
        V.
    """

    ends: Indices32
    rows: Floats
    vertices: int

    @classmethod
    def of(cls, ends: Indices32, positions: Floats, lengths: Floats) -> RigidityMatrix:
        """Assemble J from the `positions` of the vertices, (V, 3), and the lengths of the edges, (E,)."""
        return cls(ends, edge_rows(ends, positions, lengths), len(positions))

    def rates(self, motion: Floats) -> Floats:
        """``J d``, (E,): rates of the edge lengths for vertex velocities d, (V, 3)."""
        return length_rates(self.ends, self.rows, motion)

    def forces(self, tensions: Floats) -> Floats:
        """``J^T y``, (V, 3): vertex forces due to edge tensions y, (E,)."""
        return vertex_forces(self.ends, self.rows, tensions, self.vertices)

    def gram(self, indptr: Indices32, indices: Indices32, shift: float) -> Floats:
        """Entries of ``J J^T + shift I``, with the pattern of `coupled_edges`."""
        return gram_values(self.ends, self.rows, indptr, indices, shift)


def coupled_edges(ends: Indices32, vertices: int) -> tuple[Indices32, Indices32]:
    """Sparsity pattern of J J^T: edges that share a vertex are coupled.

    Parameters
    ----------
    ends : ndarray of int32, shape (E, 2)
        Ends of the edges, pairwise different.
    vertices : int

    Returns
    -------
    indptr, indices : ndarray of int32
        Compressed columns (or rows), ascending.

    Raises
    ------
    OutOfMemory
        J J^T exceeds the available memory, or the number of its entries exceeds 32 bits, as at a vertex with
        50,000 edges.
    """
    degrees = np.bincount(ends.ravel(), minlength=vertices).astype(np.int64)
    entries = int((degrees**2).sum()) - len(ends)
    if entries > np.iinfo(np.int32).max:
        raise OutOfMemory(f"J J^T would have {entries} entries, more than can be numbered in 32 bits")
    # bytes per entry of J J^T, including its position in elimination order
    require_memory(25 * entries, f"the products of {len(ends)} edges")
    return couplings(ends, degrees, entries)
