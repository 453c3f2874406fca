"""The elimination of a symmetric matrix foreseen: its tree, and the entries of each column of the factor.

Row i of the factor L has an entry in column j for every j on the paths of the elimination tree from the
entries of row i of A up to i (Liu, SIAM J. Matrix Anal. Appl. 11, 1990). To count them, these row subtrees
need not be walked: a column has as many entries as leaves of row subtrees lie below it, less the meetings of
the paths from them (Gilbert, Ng, Peyton, SIAM J. Matrix Anal. Appl. 15, 1994; Davis, Direct methods for
sparse linear systems, 2006, chapter 4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.linalg.pattern import places

Indices = NDArray[np.int64]
Pointers = NDArray[np.int32]

NONE = -1  # no parent, no child, no leaf yet


class Elimination(NamedTuple):
    """What eliminating the unknowns of a symmetric pattern in some order leads to.

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
    parent: Pointers
    counts: Indices


@njit(cache=True)
def symbolic_analysis(indptr: Pointers, indices: Pointers, order: Indices) -> Elimination:
    """Find the elimination tree, bring the order into post-order, and count the entries of L.

    Parameters
    ----------
    indptr, indices : ndarray of int32, shapes (n + 1,) and (nnz,)
        Compressed columns of a symmetric pattern, both triangles.
    order : ndarray of int64, shape (n,)
        The k-th unknown to eliminate: a permutation.
    """
    parent = _tree(indptr, indices, order, places(order))
    post = _postorder(parent)
    place = places(post)
    above = np.full(order.size, NONE, dtype=np.int32)
    for j in range(order.size):
        if parent[j] != NONE:
            above[place[j]] = place[parent[j]]
    ordered = order[post]
    return Elimination(ordered, above, _column_counts(indptr, indices, ordered, places(ordered), above))


@njit(cache=True)
def _tree(indptr: Pointers, indices: Pointers, order: Indices, place: Indices) -> Pointers:
    n = order.size
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


@njit(cache=True)
def _postorder(parent: Pointers) -> Indices:
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


@njit(cache=True)
def _column_counts(
    indptr: Pointers, indices: Pointers, order: Indices, place: Indices, parent: Pointers
) -> Indices:
    n = order.size
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


@njit(cache=True)
def _root(ancestor: Pointers, j: int) -> int:
    """The highest ancestor that was met; the way there is made shorter."""
    root = j
    while root != ancestor[root]:
        root = ancestor[root]
    while j != root:
        above = ancestor[j]
        ancestor[j] = root
        j = above
    return root
