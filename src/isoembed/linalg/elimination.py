"""Symbolic elimination of a symmetric matrix: its pattern, its tree, and the entries of each column of L.

Row i of the factor L has an entry in column j for every j on the paths of the elimination tree from the
entries of row i of A up to i (Liu, SIAM J. Matrix Anal. Appl. 11, 1990). To count them, these row subtrees
need not be walked: a column has as many entries as leaves of row subtrees lie below it, less the meetings of
the paths from them (Gilbert, Ng, Peyton, SIAM J. Matrix Anal. Appl. 15, 1994; Davis, Direct methods for
sparse linear systems, 2006, chapter 4).
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Indices, Indices32
from isoembed.kernel import kernel

NONE = -1  # no parent, no child, no leaf yet


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


@kernel
def symbolic_analysis(indptr: Indices32, indices: Indices32, order: Indices) -> Elimination:
    """Find the elimination tree, bring the order into post-order, and count the entries of L.

    The pattern is symmetric, both triangles in compressed columns; the k-th unknown to eliminate is order[k].
    """
    parent = _tree(indptr, indices, order)
    post = _postorder(parent)
    place = inverse(post)
    above = np.full(order.size, NONE, dtype=np.int32)
    for j in range(order.size):
        if parent[j] != NONE:
            above[place[j]] = place[parent[j]]
    ordered = order[post]
    return Elimination(ordered, above, _column_counts(indptr, indices, ordered, above))


@kernel
def _tree(indptr: Indices32, indices: Indices32, order: Indices) -> Indices32:
    n, place = order.size, inverse(order)
    parent = np.full(n, NONE, dtype=np.int32)
    ancestor = np.full(n, NONE, dtype=np.int32)
    for k in range(n):
        for p in range(indptr[order[k]], indptr[order[k] + 1]):
            i = place[indices[p]]
            while i != NONE and i < k:
                above = ancestor[i]
                ancestor[i] = k
                if above == NONE:
                    parent[i] = k
                i = above
    return parent


@kernel
def _postorder(parent: Indices32) -> Indices:
    """The nodes of a forest, each after its children."""
    n = parent.size
    child, sibling = np.full((2, n), NONE, dtype=np.int32)
    for j in range(n - 1, -1, -1):
        if parent[j] != NONE:
            sibling[j] = child[parent[j]]
            child[parent[j]] = j
    post, trail = np.empty((2, n), dtype=np.int64)
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
    return post


@kernel
def _column_counts(indptr: Indices32, indices: Indices32, order: Indices, parent: Indices32) -> Indices:
    n, place = order.size, inverse(order)
    counts = np.zeros(n, dtype=np.int64)
    first = np.full(n, NONE, dtype=np.int32)  # descendant
    for k in range(n):
        j = k
        counts[j] = first[j] == NONE
        while j != NONE and first[j] == NONE:
            first[j] = k
            j = parent[j]
    ancestor = np.arange(n).astype(np.int32)
    latest, leaf = np.full((2, n), NONE, dtype=np.int32)  # of each row: largest `first`, and last leaf
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
    return counts


@kernel
def _root(ancestor: Indices32, j: int) -> int:
    """The highest ancestor that was met; the way there is made shorter."""
    root = j
    while root != ancestor[root]:
        root = ancestor[root]
    while j != root:
        above = ancestor[j]
        ancestor[j] = root
        j = above
    return root


@kernel
def first_asymmetry(indptr: Indices32, indices: Indices32) -> tuple[int, int]:
    """Find an entry (row, column) whose mirror image is missing, in compressed columns with sorted rows.

    Returned are -1, -1 if there is none.
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


@kernel
def first_gap(indptr: Indices32, indices: Indices32) -> int:
    """Find an unknown without a diagonal entry, and -1 if there is none."""
    for column in range(indptr.size - 1):
        present = False
        for p in range(indptr[column], indptr[column + 1]):
            present |= indices[p] == column
        if not present:
            return column
    return -1


@kernel
def inverse(order: Indices) -> Indices:
    """Invert a permutation; an empty array if it is none."""
    n = order.size
    place = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        i = order[k]
        if i < 0 or i >= n or place[i] >= 0:
            return place[:0]
        place[i] = k
    return place


@kernel
def permuted(
    indptr: Indices32, indices: Indices32, order: Indices, lower: bool
) -> tuple[Indices32, Indices32, Indices32]:
    """Bring a symmetric pattern into elimination order, all of it or its lower triangle.

    Returns
    -------
    indptr, indices : ndarray of int32
        Compressed columns with sorted rows.
    source : ndarray of int32
        The entry of the given pattern, or its mirror image, that each entry comes from.
    """
    n, place = order.size, inverse(order)
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
