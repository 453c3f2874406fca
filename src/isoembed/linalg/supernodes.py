# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Supernodes: adjacent columns of L with the same structure.

The rows of a column of L below the diagonal are its parent in the elimination tree and some of the parent's
rows. So columns that all lie below the last of them have entries on one another's rows and on those of the
last only: they are stored as a dense trapezoid, in which some zeros are stored too.
"""

from __future__ import annotations

from typing import NamedTuple

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, Int, Int32, Real

from isoembed.arrays import Indices, Indices32
from isoembed.linalg.elimination import Elimination, inverse

NONE = cython.declare(cython.int, -1)  # no parent, as in `isoembed.linalg.elimination`
FRONT_COST = cython.declare(cython.double, 2000.0)  # multiplications that a front costs, however small
STORED_COST = cython.declare(cython.double, 30.0)  # multiplications that a stored entry of L costs
PASSED_COST = cython.declare(cython.double, 16.0)  # multiplications that an entry passed on to a parent costs


class Supernodes(NamedTuple):
    """The supernodes of a factor L, each after its children.

    Attributes
    ----------
    starts : ndarray of int64, shape (S + 1,)
        The first column of each, and last the number of columns.
    parents : ndarray of int32, shape (S,)
        The supernode of the first row below each; -1 if there is none.
    leaves : ndarray of int64, shape (S,)
        The first supernode of the subtree below each: the subtree is all that lies between them.
    offsets : ndarray of int64, shape (S + 1,)
        Where the entries of each begin in L, with the zeros that are stored; last their number.
    ends : ndarray of int64, shape (S + 1,)
        The rows below the columns of supernode s are ``rows[ends[s] : ends[s + 1]]``, sorted.
    rows : ndarray of int32
    widest : int
        Rows of the largest front.
    """

    starts: Indices
    parents: Indices32
    leaves: Indices
    offsets: Indices
    ends: Indices
    rows: Indices32
    widest: int

    @property
    def entries(self) -> int:
        """Entries of L, with the zeros that are stored."""
        return int(self.offsets[-1])


def find_supernodes(indptr: ConstInt32[::1], indices: ConstInt32[::1], elimination: Elimination):
    """Find the supernodes of a symmetric pattern, both triangles in compressed columns."""
    order: ConstInt[::1] = elimination.order
    parent: ConstInt32[::1] = elimination.parent
    counts: ConstInt[::1] = elimination.counts
    n = parent.shape[0]
    starts: Int[::1] = _amalgamated(parent, counts)
    count = starts.shape[0] - 1
    home: Int32[::1] = np.empty(n, dtype=np.int32)
    parents: Int32[::1] = np.full(count, NONE, dtype=np.int32)
    leaves: Int[::1] = np.arange(count, dtype=np.int64)
    offsets: Int[::1] = np.zeros(count + 1, dtype=np.int64)
    ends: Int[::1] = np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        for j in range(starts[s], starts[s + 1]):
            home[j] = s
        ends[s + 1] = ends[s] + counts[starts[s + 1] - 1] - 1
    widest: Int = 0
    for s in range(count):
        k, below = starts[s + 1] - starts[s], ends[s + 1] - ends[s]
        offsets[s + 1] = offsets[s] + k * (k + below) - k * (k - 1) // 2
        widest = max(widest, k + below)
        if below > 0:
            parents[s] = home[parent[starts[s + 1] - 1]]
            leaves[parents[s]] = min(leaves[parents[s]], leaves[s])
    # Row i has entries in the supernodes of its entries in A, and in those on the way up to its own.
    place: Int[::1] = inverse(order)
    rows: Int32[::1] = np.empty(ends[count], dtype=np.int32)
    end: Int[::1] = np.array(ends[:count])
    met: Int32[::1] = np.full(count, NONE, dtype=np.int32)
    for i in range(n):
        met[home[i]] = i
        for p in range(indptr[order[i]], indptr[order[i] + 1]):
            j = place[indices[p]]
            s = home[min(i, j)]
            while met[s] != i:
                met[s] = i
                rows[end[s]] = i
                end[s] += 1
                s = parents[s]
    return Supernodes(
        np.asarray(starts),
        np.asarray(parents),
        np.asarray(leaves),
        np.asarray(offsets),
        np.asarray(ends),
        np.asarray(rows),
        widest,
    )


def stack_size(nodes: Supernodes, first: Int, last: Int, before: Int):
    """Entries of the front that is being eliminated and of all that waits for its parent, at most.

    Supernodes from the first to the last are eliminated; so many entries are passed on to the first.
    """
    starts: ConstInt[::1] = nodes.starts
    parents: ConstInt32[::1] = nodes.parents
    ends: ConstInt[::1] = nodes.ends
    ready: Int[::1] = np.zeros(last - first, dtype=np.int64)  # entries that children of each pass on
    if first < last:
        ready[0] = before
    size: Int = 0
    waiting: Int = before
    for s in range(first, last):
        k, below = starts[s + 1] - starts[s], ends[s + 1] - ends[s]
        m = k + below
        size = max(size, waiting + m * (m + 1) // 2)
        passed = below * (below + 1) // 2
        waiting += passed - ready[s - first]
        if below > 0 and parents[s] < last:
            ready[parents[s] - first] += passed
    return size


@cython.cfunc
def _amalgamated(parent: ConstInt32[::1], counts: ConstInt[::1]):
    """The first columns of supernodes, and the number of columns.

    A supernode begins as one column, and takes in the one before while that is a child and this pays.
    """
    n = parent.shape[0]
    starts: Int[::1] = np.empty(n + 1, dtype=np.int64)
    tops: Int[::1] = np.empty(n + 1, dtype=np.int64)
    found: Int = 0
    for column in range(n):
        start, below = column, counts[column] - 1
        cost = _cost(1, below)
        while found > 0 and NONE < parent[tops[found - 1]] <= column:
            before, top = starts[found - 1], tops[found - 1]
            together = _cost(column + 1 - before, below)
            if together > cost + _cost(top + 1 - before, counts[top] - 1):
                break
            start, cost = before, together
            found -= 1
        starts[found], tops[found] = start, column
        found += 1
    starts[found] = n
    return np.array(starts[: found + 1])


@cython.cfunc
@cython.exceptval(check=False)
def _cost(k: Int, below: Int) -> Real:
    """Cost of a front of k columns, in multiplications."""
    m = k + below
    stored = 0.5 * STORED_COST * k * (m + below)
    return FRONT_COST + stored + 0.5 * k * (m * m - m * k + k * k / 3.0) + 0.5 * PASSED_COST * below * below
