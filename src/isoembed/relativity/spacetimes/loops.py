# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled interpolation on grids."""

from __future__ import annotations

import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Real


def contracted(fields: ConstReal[:, :, :, ::1], start: ConstInt[:, ::1], weights: ConstReal[:, :, ::1]):
    """Sums (n, m) of fields (m, nx, ny, nz) with weights (n, 3, nodes), from points `start` (n, 3) on."""
    n, m, nodes = start.shape[0], fields.shape[0], weights.shape[2]
    out: Real[:, ::1] = np.zeros((n, m))
    for p in range(n):
        i0, j0, k0 = start[p, 0], start[p, 1], start[p, 2]
        for c in range(m):
            total: Real = 0.0
            for i in range(nodes):
                for j in range(nodes):
                    row: Real = 0.0
                    for k in range(nodes):
                        row += weights[p, 2, k] * fields[c, i0 + i, j0 + j, k0 + k]
                    total += weights[p, 0, i] * weights[p, 1, j] * row
            out[p, c] = total
    return np.asarray(out)


def contracted_gradient(
    fields: ConstReal[:, :, :, ::1],
    start: ConstInt[:, ::1],
    weights: ConstReal[:, :, ::1],
    slopes: ConstReal[:, :, ::1],
):
    """Sums (n, 3, m) as in `contracted`, with slopes (n, 3, nodes) in place of the weights along one axis."""
    n, m, nodes = start.shape[0], fields.shape[0], weights.shape[2]
    out: Real[:, :, ::1] = np.zeros((n, 3, m))
    for p in range(n):
        i0, j0, k0 = start[p, 0], start[p, 1], start[p, 2]
        for c in range(m):
            x: Real = 0.0
            y: Real = 0.0
            z: Real = 0.0
            for i in range(nodes):
                for j in range(nodes):
                    row: Real = 0.0
                    slope: Real = 0.0
                    for k in range(nodes):
                        row += weights[p, 2, k] * fields[c, i0 + i, j0 + j, k0 + k]
                        slope += slopes[p, 2, k] * fields[c, i0 + i, j0 + j, k0 + k]
                    x += slopes[p, 0, i] * weights[p, 1, j] * row
                    y += weights[p, 0, i] * slopes[p, 1, j] * row
                    z += weights[p, 0, i] * weights[p, 1, j] * slope
            out[p, 0, c], out[p, 1, c], out[p, 2, c] = x, y, z
    return np.asarray(out)
