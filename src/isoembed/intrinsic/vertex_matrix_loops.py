# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled assembly of a sparse symmetric matrix over the vertices from values on half-edges."""

from __future__ import annotations

import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Int, Int32, Real


def assembled(corners: ConstInt[::1], twins: ConstInt[::1], values: ConstReal[::1], diagonal: ConstReal[::1]):
    n = diagonal.shape[0]
    indptr: Int32[::1] = np.ones(n + 1, dtype=np.int32)
    indptr[0] = 0
    for h in range(corners.shape[0]):
        indptr[corners[h] + 1] += 1
    for i in range(n):
        indptr[i + 1] += indptr[i]
    # Half-edges grouped by start vertex: one less per vertex than entries in its column.
    leaving: Int32[::1] = np.empty(corners.shape[0], dtype=np.int32)
    end: Int32[::1] = np.empty(n, dtype=np.int32)
    for i in range(n):
        end[i] = indptr[i] - i
    for h in range(corners.shape[0]):
        i = corners[h]
        leaving[end[i]] = h
        end[i] += 1
    indices: Int32[::1] = np.empty(indptr[n], dtype=np.int32)
    data: Real[::1] = np.empty(indptr[n])
    for i in range(n):
        end[i] = indptr[i]
    for i in range(n):  # columns receive their rows in order, equal ones consecutively
        indices[end[i]], data[end[i]] = i, diagonal[i]
        end[i] += 1
        for k in range(indptr[i] - i, indptr[i + 1] - i - 1):
            h = leaving[k]
            j = corners[twins[h]]
            e = end[j]
            if e > indptr[j] and indices[e - 1] == i:
                data[e - 1] += values[h]
            else:
                indices[e], data[e] = i, values[h]
                end[j] = e + 1
    count: Int = 0
    for i in range(n):
        start, indptr[i] = indptr[i], count
        if start == count:
            count = end[i]
            continue
        for e in range(start, end[i]):
            indices[count], data[count] = indices[e], data[e]
            count += 1
    indptr[n] = count
    return np.asarray(indptr), np.asarray(indices[:count]), np.asarray(data[:count])
