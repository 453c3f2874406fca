# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled products of sparse symmetric matrices in compressed columns."""

from __future__ import annotations

import numpy as np
from cython.cimports.isoembed.c_types import ConstInt32, ConstReal, Real
from cython.cimports.libc.math import sqrt


def product(indptr: ConstInt32[::1], indices: ConstInt32[::1], data: ConstReal[::1], x: ConstReal[:, ::1]):
    y: Real[:, ::1] = np.zeros_like(x)
    for c in range(x.shape[0]):
        for column in range(indptr.shape[0] - 1):
            own = x[c, column]
            total: Real = 0.0
            for p in range(indptr[column], indptr[column + 1]):
                row = indices[p]
                total += data[p] * x[c, row]
                if row != column:
                    y[c, row] += data[p] * own
            y[c, column] += total
    return np.asarray(y)


def sizes(indptr: ConstInt32[::1], indices: ConstInt32[::1], data: ConstReal[::1]):
    n = indptr.shape[0] - 1
    s: Real[::1] = np.ones(n)
    for _ in range(5):  # 24 decades between neighbors become less than one
        largest: Real[::1] = np.zeros(n)
        for column in range(n):
            for p in range(indptr[column], indptr[column + 1]):
                row = indices[p]
                size = abs(data[p]) / s[column] / s[row]
                largest[column] = max(largest[column], size)
                largest[row] = max(largest[row], size)
        for i in range(n):
            if largest[i] > 0:
                s[i] *= sqrt(largest[i])
    return np.asarray(s)
