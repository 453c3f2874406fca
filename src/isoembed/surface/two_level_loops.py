# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled aggregation, and the coarse matrix of rigid aggregates, for the two-level preconditioner."""

from __future__ import annotations

import cython
import numpy as np

if cython.compiled:
    pass
else:
    pass

Int = cython.typedef(cython.longlong)
ConstInt = cython.typedef(cython.const[cython.longlong])
Int32 = cython.typedef(cython.int)
ConstInt32 = cython.typedef(cython.const[cython.int])
Real = cython.typedef(cython.double)
ConstReal = cython.typedef(cython.const[cython.double])

MAX_AGGREGATE = cython.declare(cython.longlong, 48)  # vertices that move as one body, as in `two_level`


def take_away_rigid(motion: Real[:, ::1], arms: ConstReal[:, ::1], turning: ConstReal[:, ::1]):
    """Take from a motion, (V, 3), the translation and the rotation in it.

    ``arms`` reach from the center; ``turning`` is the inverse of their moments of inertia.
    """
    shift: Real[::1] = np.zeros(3)
    momentum: Real[::1] = np.zeros(3)
    wrench: Real[::1] = np.empty(6)
    for v in range(motion.shape[0]):
        _set_wrench(arms, v, motion[v, 0], motion[v, 1], motion[v, 2], wrench)
        for k in range(3):
            shift[k] += wrench[k]
            momentum[k] += wrench[3 + k]
    for k in range(3):
        shift[k] /= motion.shape[0]
    x: Real = turning[0, 0] * momentum[0] + turning[0, 1] * momentum[1] + turning[0, 2] * momentum[2]
    y: Real = turning[1, 0] * momentum[0] + turning[1, 1] * momentum[1] + turning[1, 2] * momentum[2]
    z: Real = turning[2, 0] * momentum[0] + turning[2, 1] * momentum[1] + turning[2, 2] * momentum[2]
    for v in range(motion.shape[0]):
        motion[v, 0] -= shift[0] + y * arms[v, 2] - z * arms[v, 1]
        motion[v, 1] -= shift[1] + z * arms[v, 0] - x * arms[v, 2]
        motion[v, 2] -= shift[2] + x * arms[v, 1] - y * arms[v, 0]


def aggregates(cells: ConstInt[::1]):
    """Number the cells of a tree, as in `Dissection.cells`, that are the largest with few vertices."""
    n = cells.shape[0]
    order: Int[::1] = np.argsort(cells)
    of_vertex: Int32[::1] = np.empty(n, dtype=np.int32)
    count: Int = 0
    start: Int
    end: Int
    bit: Int
    depth = int(np.max(cells)).bit_length()
    waiting = [(0, n, depth)]
    while waiting:
        start, end, bit = waiting.pop()
        if end - start <= MAX_AGGREGATE or bit == 0:
            for p in range(start, end):
                of_vertex[order[p]] = count
            count += 1
            continue
        middle: Int = start
        while middle < end and (cells[order[middle]] >> (bit - 1)) & 1 == 0:
            middle += 1
        if middle > start:
            waiting.append((start, middle, bit - 1))
        if end > middle:
            waiting.append((middle, end, bit - 1))
    return np.asarray(of_vertex)


def diagonal_blocks(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], vertices: Int):
    blocks: Real[:, :, ::1] = np.zeros((vertices, 3, 3))
    for e in range(ends.shape[0]):
        for side in range(2):
            v = ends[e, side]
            for i in range(3):
                for j in range(3):
                    blocks[v, i, j] += rows[e, i] * rows[e, j]
    return np.asarray(blocks)


def times_blocks(blocks: ConstReal[:, :, ::1], vectors: ConstReal[:, ::1]):
    products: Real[:, ::1] = np.zeros((vectors.shape[0], 3))
    for v in range(vectors.shape[0]):
        for i in range(3):
            for j in range(3):
                products[v, i] += blocks[v, i, j] * vectors[v, j]
    return np.asarray(products)


@cython.cfunc
@cython.exceptval(check=False)
def _set_wrench(arms: ConstReal[:, ::1], v: Int, x: Real, y: Real, z: Real, wrench: Real[::1]) -> cython.void:
    """Set a force and its moment about the center of the body."""
    wrench[0], wrench[1], wrench[2] = x, y, z
    wrench[3] = arms[v, 1] * z - arms[v, 2] * y
    wrench[4] = arms[v, 2] * x - arms[v, 0] * z
    wrench[5] = arms[v, 0] * y - arms[v, 1] * x


def wrenches_of(of_vertex: ConstInt32[::1], arms: ConstReal[:, ::1], count: Int, forces: ConstReal[:, ::1]):
    wrenches: Real[:, ::1] = np.zeros((count, 6))
    wrench: Real[::1] = np.empty(6)
    for v in range(forces.shape[0]):
        _set_wrench(arms, v, forces[v, 0], forces[v, 1], forces[v, 2], wrench)
        for k in range(6):
            wrenches[of_vertex[v], k] += wrench[k]
    return np.asarray(wrenches)


def motions_of(of_vertex: ConstInt32[::1], arms: ConstReal[:, ::1], moved: ConstReal[:, ::1]):
    motions: Real[:, ::1] = np.empty((of_vertex.shape[0], 3))
    for v in range(of_vertex.shape[0]):
        body = of_vertex[v]
        tx, ty, tz = moved[body, 0], moved[body, 1], moved[body, 2]
        wx, wy, wz = moved[body, 3], moved[body, 4], moved[body, 5]
        x, y, z = arms[v, 0], arms[v, 1], arms[v, 2]
        motions[v, 0] = tx + wy * z - wz * y
        motions[v, 1] = ty + wz * x - wx * z
        motions[v, 2] = tz + wx * y - wy * x
    return np.asarray(motions)


def coarse_blocks(
    ends: ConstInt32[:, ::1],
    rows: ConstReal[:, ::1],
    of_vertex: ConstInt32[::1],
    arms: ConstReal[:, ::1],
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    damping: Real,
):
    """``P^T (J^T J + damping I) P``, (nnz, 6, 6), P being the motions of the bodies."""
    blocks: Real[:, :, ::1] = np.zeros((indices.shape[0], 6, 6))
    bodies: Int[::1] = np.empty(2, dtype=np.int64)
    first: Real[::1] = np.empty(6)
    second: Real[::1] = np.empty(6)
    for e in range(ends.shape[0]):
        v, w = ends[e, 0], ends[e, 1]
        bodies[0], bodies[1] = of_vertex[v], of_vertex[w]
        _set_wrench(arms, v, rows[e, 0], rows[e, 1], rows[e, 2], first)
        _set_wrench(arms, w, -rows[e, 0], -rows[e, 1], -rows[e, 2], second)
        if bodies[0] == bodies[1]:
            continue
        _add_outer(blocks, _place(indptr, indices, bodies[0], bodies[0]), 1.0, first, first)
        _add_outer(blocks, _place(indptr, indices, bodies[0], bodies[1]), 1.0, first, second)
        _add_outer(blocks, _place(indptr, indices, bodies[1], bodies[0]), 1.0, second, first)
        _add_outer(blocks, _place(indptr, indices, bodies[1], bodies[1]), 1.0, second, second)
    if damping > 0:
        for u in range(of_vertex.shape[0]):
            at = _place(indptr, indices, of_vertex[u], of_vertex[u])
            for k in range(3):
                _set_wrench(arms, u, k == 0, k == 1, k == 2, first)
                _add_outer(blocks, at, damping, first, first)
    return np.asarray(blocks)


@cython.cfunc
@cython.exceptval(check=False)
def _place(indptr: ConstInt32[::1], indices: ConstInt32[::1], row: Int, column: Int) -> Int:
    """Where an entry is: that of the sorted columns of a row."""
    low: Int = indptr[row]
    high: Int = indptr[row + 1]
    while low < high:
        middle = (low + high) // 2
        if indices[middle] < column:
            low = middle + 1
        else:
            high = middle
    return low


@cython.cfunc
@cython.exceptval(check=False)
def _add_outer(blocks: Real[:, :, ::1], at: Int, factor: Real, x: Real[::1], y: Real[::1]) -> cython.void:
    """Add a multiple of the products of two vectors to a block."""
    for a in range(6):
        for b in range(6):
            blocks[at, a, b] += factor * x[a] * y[b]
