# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled residuals of local fits, and the charts of vertex neighborhoods."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, ConstReal, Int, Real
from cython.cimports.libc.math import sqrt


def subtract_products(
    matrix: object,
    rows: object,
    own: ConstReal[::1],
    vectors: ConstReal[:, ::1],
    differences: Real[:, ::1],
):
    """Fill in a range of rows of ``own v - A v`` for a matrix A in compressed rows."""
    indptr: ConstInt32[::1] = matrix.indptr
    indices: ConstInt32[::1] = matrix.indices
    weights: ConstReal[::1] = matrix.data
    first: Int = rows.start
    last: Int = rows.stop
    with cython.nogil:
        for v in range(first, last):
            x: Real = own[v] * vectors[v, 0]
            y: Real = own[v] * vectors[v, 1]
            z: Real = own[v] * vectors[v, 2]
            for p in range(indptr[v], indptr[v + 1]):
                w = indices[p]
                x -= weights[p] * vectors[w, 0]
                y -= weights[p] * vectors[w, 1]
                z -= weights[p] * vectors[w, 2]
            differences[v, 0], differences[v, 1], differences[v, 2] = x, y, z


def polar_charts(begin: Int, indptr: ConstInt[::1], indices: ConstInt32[::1], surface: object):
    """Directions of neighbors in the vertices' tangent planes, times distances in their units, (nnz, 2)."""
    vertices: ConstReal[:, ::1] = surface.vertices
    normals: ConstReal[:, ::1] = surface.normals
    units: ConstReal[::1] = surface.units
    k: Int
    charts: Real[:, ::1] = np.zeros((indices.shape[0], 2))
    first: Real[::1] = np.empty(3)
    second: Real[::1] = np.empty(3)  # perpendicular to each other and to the normal, of equal size
    for row in range(indptr.shape[0] - 1):
        v = begin + row
        unit = units[v]
        k = 0
        for c in range(1, 3):
            if abs(normals[v, c]) < abs(normals[v, k]):
                k = c
        i, j = (k + 1) % 3, (k + 2) % 3
        first[k], first[i], first[j] = 0.0, -normals[v, j], normals[v, i]
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normals[v, a] * first[b] - normals[v, b] * first[a]
        for at in range(indptr[row], indptr[row + 1]):
            w = indices[at]
            dx, dy = vertices[w, 0] - vertices[v, 0], vertices[w, 1] - vertices[v, 1]
            dz = vertices[w, 2] - vertices[v, 2]
            x = first[0] * dx + first[1] * dy + first[2] * dz
            y = second[0] * dx + second[1] * dy + second[2] * dz
            in_plane = x * x + y * y
            if in_plane > 0.0:
                stretch = sqrt((dx * dx + dy * dy + dz * dz) / in_plane) / unit
                charts[at, 0], charts[at, 1] = stretch * x, stretch * y
    return np.asarray(charts)
