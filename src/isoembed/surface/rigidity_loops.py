# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled products with the rigidity matrix J, and the entries of J J^T."""

from __future__ import annotations

import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, ConstReal, Int, Int32, Real


def couplings(ends: ConstInt32[:, ::1], degrees: ConstInt[::1], entries: Int):
    v: Int
    f: Int
    g: Int
    count, n = ends.shape[0], degrees.shape[0]
    start: Int[::1] = np.zeros(n + 1, dtype=np.int64)
    for v in range(n):
        start[v + 1] = start[v] + degrees[v]
    at: Int32[::1] = np.empty(2 * count, dtype=np.int32)
    met: Int[::1] = np.array(start[:n])
    for e in range(count):  # the edges at each vertex, ascending
        for side in range(2):
            v = ends[e, side]
            at[met[v]] = e
            met[v] += 1
    indptr: Int32[::1] = np.zeros(count + 1, dtype=np.int32)
    indices: Int32[::1] = np.empty(entries, dtype=np.int32)
    p: Int = 0
    i: Int
    j: Int
    for e in range(count):
        a, b = ends[e, 0], ends[e, 1]
        i, j = start[a], start[b]
        while i < start[a + 1] or j < start[b + 1]:
            f = at[i] if i < start[a + 1] else count
            g = at[j] if j < start[b + 1] else count
            i += f <= g
            j += g <= f
            indices[p] = min(f, g)
            p += 1
        indptr[e + 1] = p
    return np.asarray(indptr), np.asarray(indices)


def edge_rows(ends: ConstInt32[:, ::1], positions: ConstReal[:, ::1], lengths: ConstReal[::1]):
    rows: Real[:, ::1] = np.empty((ends.shape[0], 3))
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        for k in range(3):
            rows[e, k] = (positions[a, k] - positions[b, k]) / lengths[e]
    return np.asarray(rows)


def length_rates(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], motion: ConstReal[:, :]):
    rates: Real[::1] = np.empty(ends.shape[0])
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        rates[e] = (
            rows[e, 0] * (motion[a, 0] - motion[b, 0])
            + rows[e, 1] * (motion[a, 1] - motion[b, 1])
            + rows[e, 2] * (motion[a, 2] - motion[b, 2])
        )
    return np.asarray(rates)


def vertex_forces(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], tensions: ConstReal[::1], vertices: Int):
    forces: Real[:, ::1] = np.zeros((vertices, 3))
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        x, y, z = rows[e, 0] * tensions[e], rows[e, 1] * tensions[e], rows[e, 2] * tensions[e]
        forces[a, 0] += x  # unrolled: a loop would be ten times slower
        forces[a, 1] += y
        forces[a, 2] += z
        forces[b, 0] -= x
        forces[b, 1] -= y
        forces[b, 2] -= z
    return np.asarray(forces)


def gram_values(
    ends: ConstInt32[:, ::1],
    rows: ConstReal[:, ::1],
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    shift: Real,
):
    values: Real[::1] = np.empty(indices.shape[0])
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        x, y, z = rows[e, 0], rows[e, 1], rows[e, 2]
        for p in range(indptr[e], indptr[e + 1]):
            f = indices[p]
            product = x * rows[f, 0] + y * rows[f, 1] + z * rows[f, 2]
            first: Int = ends[f, 0] == a  # or they end at the same vertex, or one ends where the other starts
            last: Int = ends[f, 1] == b
            values[p] = product * (2 * (first | last) - 1)  # a branch would be predicted wrong half the time
            if f == e:
                values[p] = 2.0 * product + shift
    return np.asarray(values)
