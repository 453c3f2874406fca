"""Kernels on sparse patterns: symmetry, the entries in elimination order."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Indices = NDArray[np.int64]
Pointers = NDArray[np.int32]


@njit(cache=True)
def first_asymmetry(indptr: Pointers, indices: Pointers) -> tuple[int, int]:
    """Find an entry (row, column) whose mirror image is missing, and -1, -1 if there is none.

    Parameters
    ----------
    indptr, indices : ndarray of int32, shapes (n + 1,) and (nnz,)
        Compressed columns with sorted rows.
    """
    n = indptr.size - 1
    reached = indptr[:-1].copy()  # rows of each column below it met their mirror images
    for column in range(n):
        for p in range(indptr[column], indptr[column + 1]):
            row = indices[p]
            q = reached[row]
            if q == indptr[row + 1] or indices[q] > column:
                return row, column
            if indices[q] < column:
                return indices[q], row
            reached[row] = q + 1
    return -1, -1


@njit(cache=True)
def first_gap(indptr: Pointers, indices: Pointers) -> int:
    """Find an unknown without a diagonal entry, and -1 if there is none."""
    for column in range(indptr.size - 1):
        present = False
        for p in range(indptr[column], indptr[column + 1]):
            present |= indices[p] == column
        if not present:
            return column
    return -1


@njit(cache=True)
def places(order: Indices) -> Indices:
    """Invert a permutation; an empty array if it is none."""
    n = order.size
    place = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        i = order[k]
        if i < 0 or i >= n or place[i] >= 0:
            return place[:0]
        place[i] = k
    return place


@njit(cache=True)
def eliminated(
    indptr: Pointers, indices: Pointers, order: Indices, place: Indices, lower: bool
) -> tuple[Pointers, Pointers, Pointers]:
    """Bring a symmetric pattern into elimination order.

    Parameters
    ----------
    indptr, indices : ndarray of int32, shapes (n + 1,) and (nnz,)
        Compressed columns.
    order, place : ndarray of int64, shape (n,)
        The k-th unknown to eliminate, and its inverse.
    lower : bool
        Keep only the lower triangle.

    Returns
    -------
    indptr, indices : ndarray of int32
        Compressed columns with sorted rows.
    source : ndarray of int32
        The entry of the given pattern, or its mirror image, that each entry comes from.
    """
    n = order.size
    new_indptr = np.zeros(n + 1, dtype=np.int32)
    for row in range(n):
        for p in range(indptr[order[row]], indptr[order[row] + 1]):
            column = place[indices[p]]
            if column <= row or not lower:
                new_indptr[column + 1] += 1
    new_indptr = np.cumsum(new_indptr).astype(np.int32)
    end = new_indptr[:-1].copy()
    new_indices = np.empty(new_indptr[n], dtype=np.int32)
    source = np.empty(new_indptr[n], dtype=np.int32)
    for row in range(n):  # the entries of a column are met in order of their rows
        for p in range(indptr[order[row]], indptr[order[row] + 1]):
            column = place[indices[p]]
            if column <= row or not lower:
                new_indices[end[column]] = row
                source[end[column]] = p
                end[column] += 1
    return new_indptr, new_indices, source
