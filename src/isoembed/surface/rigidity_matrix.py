"""Matrix-free products with the rigidity matrix J, and assembly of J J^T.

A row of J per edge holds ``(x_a - x_b)^T / l_ab`` at a and its negative at b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32
from isoembed.linalg.memory import OutOfMemory, require_memory
from isoembed.surface.rigidity_loops import couplings, edge_rows, gram_values, length_rates, vertex_forces

MEAN_DIAGONAL = 2.0  # of J J^T, whose rows have unit norm at each end, and, nearly, of J^T J


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
        """J where the vertices are at `positions`, (V, 3), and the edges have these lengths, (E,)."""
        return cls(ends, edge_rows(ends, positions, lengths), len(positions))

    def rates(self, motion: Floats) -> Floats:
        """``J d``, (E,): how fast the edges grow if the vertices move with d, (V, 3)."""
        return length_rates(self.ends, self.rows, motion)

    def forces(self, tensions: Floats) -> Floats:
        """``J^T y``, (V, 3): the sums of the tensions y, (E,), of the edges at each vertex."""
        return vertex_forces(self.ends, self.rows, tensions, self.vertices)

    def gram(self, indptr: Indices32, indices: Indices32, shift: float) -> Floats:
        """The entries of ``J J^T + shift I``, with the pattern of `coupled_edges`."""
        return gram_values(self.ends, self.rows, indptr, indices, shift)


def coupled_edges(ends: Indices32, vertices: int) -> tuple[Indices32, Indices32]:
    """The pattern of J J^T: two edges are coupled where they share a vertex.

    Parameters
    ----------
    ends : ndarray of int32, shape (E, 2)
        Different from edge to edge.
    vertices : int

    Returns
    -------
    indptr, indices : ndarray of int32
        Compressed columns, or rows, ascending.

    Raises
    ------
    OutOfMemory
        J J^T does not fit into the memory that is free, or has more entries than 32 bits can number, as at a
        vertex with 50,000 edges.
    """
    degrees = np.bincount(ends.ravel(), minlength=vertices).astype(np.int64)
    entries = int((degrees**2).sum()) - len(ends)
    if entries > np.iinfo(np.int32).max:
        raise OutOfMemory(f"J J^T would have {entries} entries, more than can be numbered in 32 bits")
    # bytes of an entry of J J^T, with its place in elimination order
    require_memory(25 * entries, f"the products of {len(ends)} edges")
    return couplings(ends, degrees, entries)
