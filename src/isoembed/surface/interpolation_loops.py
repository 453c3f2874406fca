# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled interpolation from coarse vertices: their selection, matrix products, rigidity."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Flag, Int, Real, Single
from cython.cimports.isoembed.linalg.blas import multiply_transposed
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


def row_differences(indptr: ConstInt[::1], weights: ConstReal[::1], rows: ConstInt[:, ::1]):
    """Entries of the differences of pairs of rows of a matrix with the same columns, one after the other."""
    at: Int = 0
    for p in range(rows.shape[0]):
        at += indptr[rows[p, 0] + 1] - indptr[rows[p, 0]]
    differences: Real[::1] = np.empty(at)
    at = 0
    for p in range(rows.shape[0]):
        first, second = indptr[rows[p, 0]], indptr[rows[p, 1]]
        size = indptr[rows[p, 0] + 1] - first
        for i in range(size):
            differences[at + i] = weights[first + i] - weights[second + i]
        at += size
    return np.asarray(differences)


def add_cell_products(
    matrix: object, vectors: ConstReal[:, ::1], pattern: object, columns: object, values: Real[::1]
):
    """Add the Gram matrices of each cell's rows to a symmetric matrix: some columns, from the diagonal down.

    Parameters
    ----------
    matrix : CellRows
    vectors : ndarray, shape (M, 3)
        A row of the matrix times each: three columns for each of its columns.
    pattern : csc_array
        One entry for each block of 3 x 3 of the symmetric matrix.
    columns : range
        Columns of the pattern.
    values : ndarray, shape (9 nnz,)
        Entries of the symmetric matrix, column by column.
    """
    starts: ConstInt[::1] = matrix.starts
    offsets: ConstInt[::1] = matrix.offsets
    stencil_indptr: ConstInt[::1] = matrix.stencils[0]
    stencil: ConstInt[::1] = matrix.stencils[1]
    weights: ConstReal[::1] = matrix.weights
    indptr: ConstInt[::1] = pattern.indptr
    indices: ConstInt[::1] = pattern.indices
    begin: Int = columns.start
    end: Int = columns.stop
    n = indptr.shape[0] - 1
    size: Int = 3 * _largest(stencil_indptr, 0, n)
    most: Int = _largest(starts, 0, n)
    right: Single[::1] = np.empty(most * size, dtype=np.float32)
    work: Single[::1] = np.empty((most + size) * size, dtype=np.float32)  # the left matrix, and the product
    with cython.nogil:
        for cell in range(n):
            first, last = starts[cell], starts[cell + 1]
            j0, j2 = stencil_indptr[cell], stencil_indptr[cell + 1]
            count = j2 - j0
            while j0 < j2 and stencil[j0] < begin:
                j0 += 1
            j1 = j0
            while j1 < j2 and stencil[j1] < end:
                j1 += 1
            if j0 == j1 or first == last:
                continue
            own, width = 3 * (j1 - j0), 3 * (j2 - j0)
            at = offsets[cell] + count - (j2 - j0)
            for row in range(first, last):
                u, v = (row - first) * own, (row - first) * width
                for j in range(j2 - j0):
                    for k in range(3):
                        right[v + 3 * j + k] = weights[at + j] * vectors[row, k]
                for i in range(own):
                    work[u + i] = right[v + i]
                at += count
            multiply_transposed(work, last - first, own, right, width, width)
            for j in range(j0, j1):
                start, stop = indptr[stencil[j]], indptr[stencil[j] + 1]
                p, product = start, (last - first) * own + 3 * (j - j0) * width
                for i in range(j, j2):
                    while indices[p] < stencil[i]:
                        p += 1
                    place = 9 * start + 3 * (p - start)
                    for b in range(3):
                        for a in range(3):
                            values[place + 3 * b * (stop - start) + a] += work[
                                product + b * width + 3 * (i - j0) + a
                            ]


def mirror_blocks(pattern: object, values: Real[::1]):
    """Copy the entries of a symmetric matrix in blocks of 3 x 3 from below the diagonal to above it."""
    indptr: ConstInt[::1] = pattern.indptr
    indices: ConstInt[::1] = pattern.indices
    n = indptr.shape[0] - 1
    above: Int[::1] = np.array(indptr[:n])  # the next block above the diagonal, by column
    with cython.nogil:
        for column in range(n):
            start, width = indptr[column], 3 * (indptr[column + 1] - indptr[column])
            for p in range(above[column] + 1, indptr[column + 1]):  # after that on the diagonal
                row = indices[p]
                first, mirrored = indptr[row], 3 * (indptr[row + 1] - indptr[row])
                place = 9 * start + 3 * (p - start)
                image = 9 * first + 3 * (above[row] - first)
                above[row] += 1
                for b in range(3):
                    for a in range(3):
                        values[image + a * mirrored + b] = values[place + b * width + a]
