# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled interpolation from coarse vertices: their selection, matrix products, rigidity."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Flag, Int, Real, Single
from cython.cimports.libc.math import sqrt

INF = cython.declare(cython.double, float("inf"))


def chosen_centers(
    indptr: ConstInt[::1], indices: ConstInt[::1], hops: ConstReal[::1], order: ConstInt[::1], radius: Real
):
    """Vertices, in order, farther than the radius from all chosen before, and the cell of every vertex."""
    n = indptr.shape[0] - 1
    distance: Real[::1] = np.full(n, INF)
    cell: Int[::1] = np.full(n, -1, dtype=np.int64)
    waiting: Int[::1] = np.empty(n, dtype=np.int64)
    is_waiting: Flag[::1] = np.zeros(n, dtype=np.bool_)  # `waiting` is a ring buffer
    chosen: Int[::1] = np.empty(n, dtype=np.int64)
    count: Int = 0
    head: Int
    size: Int
    for v in order:
        if distance[v] <= radius:
            continue
        chosen[count], distance[v], cell[v] = v, 0.0, count
        waiting[0] = v
        head = 0
        size = 1
        while size > 0:
            u = waiting[head]
            head, size = (head + 1) % n, size - 1
            is_waiting[u] = False
            for p in range(indptr[u], indptr[u + 1]):
                w, there = indices[p], distance[u] + hops[p]
                if there < distance[w] and there <= 2 * radius:
                    distance[w], cell[w] = there, count
                    if not is_waiting[w]:
                        waiting[(head + size) % n], is_waiting[w] = w, True
                        size += 1
        count += 1
    return np.array(chosen[:count]), np.asarray(cell)


def multiply_cells(matrix: object, cells: object, values: ConstReal[:, ::1], products: Real[:, ::1]):
    """Fill in the rows of a range of cells in the product of `CellRows` with values (C, 3)."""
    rows: ConstInt[::1] = matrix.rows
    starts: ConstInt[::1] = matrix.starts
    offsets: ConstInt[::1] = matrix.offsets
    indptr: ConstInt[::1] = matrix.stencils[0]
    indices: ConstInt[::1] = matrix.stencils[1]
    weights: ConstReal[::1] = matrix.weights
    first: Int = cells.start
    last: Int = cells.stop
    stencil: Real[:, ::1] = np.empty((3, _largest(indptr, first, last)))
    with cython.nogil:
        for cell in range(first, last):
            begin, size, at = indptr[cell], indptr[cell + 1] - indptr[cell], offsets[cell]
            for i in range(size):
                for k in range(3):  # contiguous rows vectorize
                    stencil[k, i] = values[indices[begin + i], k]
            for p in range(starts[cell], starts[cell + 1]):
                x: Real = 0.0
                y: Real = 0.0
                z: Real = 0.0
                for i in range(size):
                    x += weights[at + i] * stencil[0, i]
                    y += weights[at + i] * stencil[1, i]
                    z += weights[at + i] * stencil[2, i]
                at += size
                row = rows[p]
                products[row, 0], products[row, 1], products[row, 2] = x, y, z


def add_transposed_cells(matrix: object, cells: object, forces: ConstReal[:, ::1], products: Real[:, ::1]):
    """Add what a range of cells contributes to the product of transposed `CellRows` with forces (n, 3)."""
    rows: ConstInt[::1] = matrix.rows
    starts: ConstInt[::1] = matrix.starts
    offsets: ConstInt[::1] = matrix.offsets
    indptr: ConstInt[::1] = matrix.stencils[0]
    indices: ConstInt[::1] = matrix.stencils[1]
    weights: ConstReal[::1] = matrix.weights
    first: Int = cells.start
    last: Int = cells.stop
    sums: Real[:, ::1] = np.empty((3, _largest(indptr, first, last)))
    with cython.nogil:
        for cell in range(first, last):
            begin, size, at = indptr[cell], indptr[cell + 1] - indptr[cell], offsets[cell]
            for k in range(3):
                for i in range(size):
                    sums[k, i] = 0.0
            end = starts[cell + 1]
            for p in range(starts[cell], end, 2):  # two rows at once: the sums are read and written once
                row, after = rows[p], rows[min(p + 1, end - 1)]
                second = at + size if p + 1 < end else at
                for k in range(3):
                    force = forces[row, k]
                    other: Real = forces[after, k] if p + 1 < end else 0.0
                    for i in range(size):
                        sums[k, i] += force * weights[at + i] + other * weights[second + i]
                at += 2 * size
            for i in range(size):
                for k in range(3):
                    products[indices[begin + i], k] += sums[k, i]


@cython.cfunc
def _largest(indptr: ConstInt[::1], first: Int, last: Int) -> Int:
    """Size of the largest of some stencils."""
    size: Int = 0
    for cell in range(first, last):
        size = max(size, indptr[cell + 1] - indptr[cell])
    return size


def projected(
    points: ConstReal[:, ::1],
    normals: ConstReal[:, ::1],
    units: ConstReal[::1],
    targets: ConstReal[:, ::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
):
    """Orthogonal projections of targets to the tangent planes at points, in their units, (nnz, 2).

    Polar charts would not be smooth coordinates on surfaces other than spheres.
    """
    x: Real
    y: Real
    k: Int
    charts: Real[:, ::1] = np.empty((indices.shape[0], 2))
    first: Real[::1] = np.empty(3)
    second: Real[::1] = np.empty(3)
    for row in range(points.shape[0]):
        unit = units[row]
        k = 0
        for c in range(1, 3):
            if abs(normals[row, c]) < abs(normals[row, k]):
                k = c
        i, j = (k + 1) % 3, (k + 2) % 3
        size = sqrt(normals[row, i] * normals[row, i] + normals[row, j] * normals[row, j])
        first[k], first[i], first[j] = 0.0, -normals[row, j] / size, normals[row, i] / size
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normals[row, a] * first[b] - normals[row, b] * first[a]
        for at in range(indptr[row], indptr[row + 1]):
            there = indices[at]
            x = y = 0.0
            for c in range(3):
                x += first[c] * (targets[there, c] - points[row, c])
                y += second[c] * (targets[there, c] - points[row, c])
            charts[at, 0], charts[at, 1] = x / unit, y / unit
    return np.asarray(charts)


def cell_products(
    starts: ConstInt[::1],
    stencil_indptr: ConstInt[::1],
    stencil_indices: ConstInt[::1],
    differences: ConstReal[::1],
    rows: ConstReal[:, ::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
):
    """Sum of the Gram matrices of each cell's rows, a symmetric matrix in blocks of 3 x 3.

    It is accumulated below the diagonal block by block, then copied to the columns and above the diagonal.
    """
    n = indptr.shape[0] - 1
    diagonal: Int[::1] = np.empty(n, dtype=np.int64)
    for column in range(n):
        p: Int = indptr[column]
        while indices[p] < column:
            p += 1
        diagonal[column] = p
    blocks: Real[:, ::1] = np.zeros((indices.shape[0], 9))
    at: Int = 0  # in the differences
    for cell in range(n):
        first, last = starts[cell], starts[cell + 1]
        begin = stencil_indptr[cell]
        size = stencil_indptr[cell + 1] - begin
        if first == last:
            continue
        dense = np.empty((last - first, 3 * size), dtype=np.float32)
        J: Single[:, ::1] = dense
        for edge in range(first, last):
            for j in range(size):
                for k in range(3):
                    J[edge - first, 3 * j + k] = differences[at] * rows[edge, k]
                at += 1
        products: Single[:, ::1] = np.dot(dense.T, dense.copy())  # without the copy, NumPy mirrors one half
        for j in range(size):
            p = diagonal[stencil_indices[begin + j]]
            for i in range(j, size):
                row = stencil_indices[begin + i]
                while indices[p] < row:
                    p += 1
                for b in range(3):
                    for a in range(3):
                        blocks[p, 3 * b + a] += products[3 * j + b, 3 * i + a]
    values: Real[::1] = np.empty(9 * indices.shape[0])
    above: Int[::1] = np.array(indptr[:n])  # the next block above the diagonal, by column
    for column in range(n):
        start, width = indptr[column], 3 * (indptr[column + 1] - indptr[column])
        for p in range(diagonal[column], indptr[column + 1]):
            row = indices[p]
            first, mirrored = indptr[row], 3 * (indptr[row + 1] - indptr[row])
            place = 9 * start + 3 * (p - start)
            image = 9 * first + 3 * (above[row] - first)
            above[row] += 1
            for b in range(3):
                for a in range(3):
                    values[image + a * mirrored + b] = blocks[p, 3 * b + a]
                    values[place + b * width + a] = blocks[p, 3 * b + a]
    return np.asarray(values)
