"""Symmetric sparse matrices on the vertices of triangles, with an entry for every edge."""

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.kernel import kernel


def vertex_matrix(corners: Indices, twins: Indices, values: Floats, diagonal: Floats) -> csc_array:
    """Sum values by half-edge and by vertex into a matrix; what vanishes is kept in its pattern.

    Parameters
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As of `isoembed.intrinsic.halfedges.HalfEdges`.
    values : ndarray, shape (3F,)
        The entry at the two ends of each half-edge; equal on twins.
    diagonal : ndarray, shape (V,)

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric, its rows sorted within columns.  Repeated edges are summed, and loops into the diagonal.
    """
    n = diagonal.size
    indptr, indices, data = _assembled(corners, twins, values, diagonal)
    return csc_array((data, indices, indptr), shape=(n, n))


@kernel
def _assembled(
    corners: Indices, twins: Indices, values: Floats, diagonal: Floats
) -> tuple[Indices32, Indices32, Floats]:
    n = diagonal.size
    indptr = np.ones(n + 1, dtype=np.int32)
    indptr[0] = 0
    for h in range(corners.size):
        indptr[corners[h] + 1] += 1
    for i in range(n):
        indptr[i + 1] += indptr[i]
    # The half-edges by the vertex that they leave: one entry less a vertex than there are in its column.
    leaving = np.empty(corners.size, dtype=np.int32)
    end = np.empty(n, dtype=np.int32)
    for i in range(n):
        end[i] = indptr[i] - i
    for h in range(corners.size):
        i = corners[h]
        leaving[end[i]] = h
        end[i] += 1
    indices, data = np.empty(indptr[n], dtype=np.int32), np.empty(indptr[n])
    for i in range(n):
        end[i] = indptr[i]
    for i in range(n):  # columns get their rows in order, and equal ones one after the other
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
    count = 0
    for i in range(n):
        start, indptr[i] = indptr[i], count
        if start == count:
            count = end[i]
            continue
        for e in range(start, end[i]):
            indices[count], data[count] = indices[e], data[e]
            count += 1
    indptr[n] = count
    return indptr, indices[:count], data[:count]
