"""The rigidity matrix J as three numbers an edge: products with it, and J J^T, without building it.

A row of J per edge holds ``(x_a - x_b)^T / l_ab`` at a and its negative at b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.kernel import kernel
from isoembed.linalg.memory import OutOfMemory, require_memory

DIAGONAL_SHIFT = 1e-10  # relative, added to J^T J: it fixes the motions that change no edge


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
        return cls(ends, _rows(ends, positions, lengths), len(positions))

    def rates(self, motion: Floats) -> Floats:
        """``J d``, (E,): how fast the edges grow if the vertices move with d, (V, 3)."""
        return _rates(self.ends, self.rows, motion)

    def forces(self, tensions: Floats) -> Floats:
        """``J^T y``, (V, 3): the sums of the tensions y, (E,), of the edges at each vertex."""
        return _forces(self.ends, self.rows, tensions, self.vertices)

    def gram(self, indptr: Indices32, indices: Indices32, shift: float) -> Floats:
        """The entries of ``J J^T + shift I``, with the pattern of `coupled_edges`."""
        return _gram(self.ends, self.rows, indptr, indices, shift)


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
    return _coupled(ends, degrees, entries)


@kernel
def _coupled(ends: Indices32, degrees: Indices, entries: int) -> tuple[Indices32, Indices32]:
    count, n = len(ends), degrees.size
    start = np.zeros(n + 1, dtype=np.int64)
    start[1:] = np.cumsum(degrees)
    at, met = np.empty(2 * count, dtype=np.int32), start[:-1].copy()
    for e in range(count):  # the edges at each vertex, ascending
        for v in ends[e]:
            at[met[v]] = e
            met[v] += 1
    indptr, indices = np.zeros(count + 1, dtype=np.int32), np.empty(entries, dtype=np.int32)
    p = 0
    for e in range(count):
        a, b = ends[e]
        i, j = start[a], start[b]
        while i < start[a + 1] or j < start[b + 1]:
            f = at[i] if i < start[a + 1] else count
            g = at[j] if j < start[b + 1] else count
            i += f <= g
            j += g <= f
            indices[p] = min(f, g)
            p += 1
        indptr[e + 1] = p
    return indptr, indices


@kernel
def _rows(ends: Indices32, positions: Floats, lengths: Floats) -> Floats:
    rows = np.empty((len(ends), 3))
    for e in range(len(ends)):
        a, b = ends[e]
        for k in range(3):
            rows[e, k] = (positions[a, k] - positions[b, k]) / lengths[e]
    return rows


@kernel
def _rates(ends: Indices32, rows: Floats, motion: Floats) -> Floats:
    rates = np.empty(len(ends))
    for e in range(len(ends)):
        a, b = ends[e]
        rates[e] = (
            rows[e, 0] * (motion[a, 0] - motion[b, 0])
            + rows[e, 1] * (motion[a, 1] - motion[b, 1])
            + rows[e, 2] * (motion[a, 2] - motion[b, 2])
        )
    return rates


@kernel
def _forces(ends: Indices32, rows: Floats, tensions: Floats, vertices: int) -> Floats:
    forces = np.zeros((vertices, 3))
    for e in range(len(ends)):
        a, b = ends[e]
        x, y, z = rows[e, 0] * tensions[e], rows[e, 1] * tensions[e], rows[e, 2] * tensions[e]
        forces[a, 0] += x  # a loop would read these back ten times as slowly
        forces[a, 1] += y
        forces[a, 2] += z
        forces[b, 0] -= x
        forces[b, 1] -= y
        forces[b, 2] -= z
    return forces


@kernel
def _gram(ends: Indices32, rows: Floats, indptr: Indices32, indices: Indices32, shift: float) -> Floats:
    values = np.empty(indices.size)
    for e in range(len(ends)):
        a, b = ends[e]
        x, y, z = rows[e]
        for p in range(indptr[e], indptr[e + 1]):
            f = indices[p]
            product = x * rows[f, 0] + y * rows[f, 1] + z * rows[f, 2]
            if f == e:
                values[p] = 2.0 * product + shift
            elif ends[f, 0] == a or ends[f, 1] == b:
                values[p] = product
            else:  # one ends where the other begins
                values[p] = -product
    return values
