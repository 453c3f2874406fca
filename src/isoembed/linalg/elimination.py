# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Symbolic elimination: elimination tree and column counts of the factor L.

Row i of the factor L has an entry in column j for every j on the paths of the elimination tree from the
entries of row i of A up to i (Liu, SIAM J. Matrix Anal. Appl. 11, 1990). To count them, these row subtrees
need not be walked: a column has as many entries as leaves of row subtrees lie below it, less the meetings of
the paths from them (Gilbert, Ng, Peyton, SIAM J. Matrix Anal. Appl. 15, 1994; Davis, Direct methods for
sparse linear systems, 2006, chapter 4).
"""

from __future__ import annotations

from typing import NamedTuple

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, Int, Int32

from isoembed.arrays import Indices, Indices32

# no parent, no child, no leaf yet
NONE = cython.declare(cython.int, -1)


class Elimination(NamedTuple):
    """Elimination of the unknowns of a symmetric pattern.

    Attributes
    ----------
    order : ndarray of int64, shape (n,)
        The k-th unknown to eliminate, subtree after subtree: as good as the order that was asked for.
    parent : ndarray of int32, shape (n,)
        The row of the first entry below the diagonal in each column of L, in this order; -1 if there is none.
    counts : ndarray of int64, shape (n,)
        The entries in each column of L, the diagonal among them.
    """

    order: Indices
    parent: Indices32
    counts: Indices


def symbolic_analysis(indptr: ConstInt32[::1], indices: ConstInt32[::1], order: ConstInt[::1]):
    """Find the elimination tree, bring the order into post-order, and count the entries of L.

    The pattern is symmetric, both triangles in compressed columns; the k-th unknown to eliminate is order[k].
    """
    parent: Int32[::1] = _tree(indptr, indices, order)
    post = _postorder(parent)
    place: Int[::1] = inverse(post)
    above: Int32[::1] = np.full(order.shape[0], NONE, dtype=np.int32)
    for j in range(order.shape[0]):
        if parent[j] != NONE:
            above[place[j]] = place[parent[j]]
    ordered = np.asarray(order)[post]
    return Elimination(ordered, np.asarray(above), _column_counts(indptr, indices, ordered, above))


@cython.cfunc
def _tree(indptr: ConstInt32[::1], indices: ConstInt32[::1], order: ConstInt[::1]):
    n = order.shape[0]
    place: Int[::1] = inverse(order)
    parent: Int32[::1] = np.full(n, NONE, dtype=np.int32)
    ancestor: Int32[::1] = np.full(n, NONE, dtype=np.int32)
    for k in range(n):
        for p in range(indptr[order[k]], indptr[order[k] + 1]):
            i = place[indices[p]]
            while i != NONE and i < k:
                above = ancestor[i]
                ancestor[i] = k
                if above == NONE:
                    parent[i] = k
                i = above
    return np.asarray(parent)


@cython.cfunc
def _postorder(parent: ConstInt32[::1]):
    """The nodes of a forest, each after its children."""
    n = parent.shape[0]
    child: Int32[::1] = np.full(n, NONE, dtype=np.int32)
    sibling: Int32[::1] = np.full(n, NONE, dtype=np.int32)
    for j in range(n - 1, -1, -1):
        if parent[j] != NONE:
            sibling[j] = child[parent[j]]
            child[parent[j]] = j
    post: Int[::1] = np.empty(n, dtype=np.int64)
    trail: Int[::1] = np.empty(n, dtype=np.int64)
    done = 0
    for root in range(n):
        if parent[root] != NONE:
            continue
        trail[0], depth = root, 1
        while depth > 0:
            j = trail[depth - 1]
            if child[j] == NONE:
                post[done] = j
                done += 1
                depth -= 1
            else:
                trail[depth] = child[j]
                depth += 1
                child[j] = sibling[child[j]]
    return np.asarray(post)


@cython.cfunc
def _column_counts(
    indptr: ConstInt32[::1], indices: ConstInt32[::1], order: ConstInt[::1], parent: ConstInt32[::1]
):
    n = order.shape[0]
    place: Int[::1] = inverse(order)
    counts: Int[::1] = np.zeros(n, dtype=np.int64)
    first: Int32[::1] = np.full(n, NONE, dtype=np.int32)  # descendant
    for k in range(n):
        j = k
        counts[j] = first[j] == NONE
        while j != NONE and first[j] == NONE:
            first[j] = k
            j = parent[j]
    ancestor: Int32[::1] = np.arange(n).astype(np.int32)
    latest: Int32[::1] = np.full(n, NONE, dtype=np.int32)  # of each row: largest `first`
    leaf: Int32[::1] = np.full(n, NONE, dtype=np.int32)  # and the last leaf
    for j in range(n):
        if parent[j] != NONE:
            counts[parent[j]] -= 1
        for p in range(indptr[order[j]], indptr[order[j] + 1]):
            i = place[indices[p]]
            if i <= j or first[j] <= latest[i]:
                continue
            latest[i] = first[j]
            counts[j] += 1
            if leaf[i] != NONE:  # the paths from this leaf and from the one before meet
                counts[_root(ancestor, leaf[i])] -= 1
            leaf[i] = j
        if parent[j] != NONE:
            ancestor[j] = parent[j]
    for j in range(n):
        if parent[j] != NONE:
            counts[parent[j]] += counts[j]
    return np.asarray(counts)


@cython.cfunc
@cython.exceptval(check=False)
def _root(ancestor: Int32[::1], j: Int) -> Int:
    """The highest ancestor that was met; the way there is made shorter."""
    root = j
    while root != ancestor[root]:
        root = ancestor[root]
    while j != root:
        above = ancestor[j]
        ancestor[j] = root
        j = above
    return root


def first_asymmetry(indptr: ConstInt32[::1], indices: ConstInt32[::1]):
    """Find an entry (row, column) whose mirror image is missing, in compressed columns with sorted rows.

    Returned are -1, -1 if there is none.
    """
    n = indptr.shape[0] - 1
    reached: Int32[::1] = np.array(indptr[:n])  # rows of each column below it met their mirror images
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


def first_gap(indptr: ConstInt32[::1], indices: ConstInt32[::1]):
    """Find an unknown without a diagonal entry, and -1 if there is none."""
    for column in range(indptr.shape[0] - 1):
        present: cython.bint = False
        for p in range(indptr[column], indptr[column + 1]):
            present |= indices[p] == column
        if not present:
            return column
    return -1


def inverse(order: ConstInt[::1]):
    """Invert a permutation; an empty array if it is not one."""
    n = order.shape[0]
    place: Int[::1] = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        i = order[k]
        if i < 0 or i >= n or place[i] >= 0:
            return np.asarray(place[:0])
        place[i] = k
    return np.asarray(place)


def permuted(indptr: ConstInt32[::1], indices: ConstInt32[::1], order: ConstInt[::1], lower: cython.bint):
    """Bring a symmetric pattern into elimination order, all of it or its lower triangle.

    Returns
    -------
    indptr, indices : ndarray of int32
        Compressed columns with sorted rows.
    source : ndarray of int32
        The entry of the given pattern, or its mirror image, that each entry comes from.
    """
    n = order.shape[0]
    place: Int[::1] = inverse(order)
    new_indptr: Int32[::1] = np.zeros(n + 1, dtype=np.int32)
    for row in range(n):
        for p in range(indptr[order[row]], indptr[order[row] + 1]):
            column = place[indices[p]]
            if column <= row or not lower:
                new_indptr[column + 1] += 1
    for column in range(n):
        new_indptr[column + 1] += new_indptr[column]
    end: Int32[::1] = np.array(new_indptr[:n])
    new_indices: Int32[::1] = np.empty(new_indptr[n], dtype=np.int32)
    source: Int32[::1] = np.empty(new_indptr[n], dtype=np.int32)
    for row in range(n):  # the entries of a column are met in order of their rows
        for p in range(indptr[order[row]], indptr[order[row] + 1]):
            column = place[indices[p]]
            if column <= row or not lower:
                new_indices[end[column]] = row
                source[end[column]] = p
                end[column] += 1
    return np.asarray(new_indptr), np.asarray(new_indices), np.asarray(source)
