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
    children : ndarray of int64, shape (S,)
        How many supernodes each is the parent of.
    ends : ndarray of int64, shape (S + 1,)
        The rows below the columns of supernode s are ``rows[ends[s] : ends[s + 1]]``, sorted.
    rows : ndarray of int32
    entries : int
        Of L, with the zeros that are stored.
    widest : int
        Rows of the largest front.
    room : int
        Entries of the front that is being eliminated and of all that waits for its parent, at most.
    """

    starts: Indices
    children: Indices
    ends: Indices
    rows: Indices32
    entries: int
    widest: int
    room: int


def find_supernodes(indptr: ConstInt32[::1], indices: ConstInt32[::1], elimination: Elimination):
    """Find the supernodes of a symmetric pattern, both triangles in compressed columns."""
    order: ConstInt[::1] = elimination.order
    parent: ConstInt32[::1] = elimination.parent
    counts: ConstInt[::1] = elimination.counts
    n = parent.shape[0]
    starts: Int[::1] = _amalgamated(parent, counts)
    count = starts.shape[0] - 1
    home: Int32[::1] = np.empty(n, dtype=np.int32)
    above: Int32[::1] = np.full(count, NONE, dtype=np.int32)
    children: Int[::1] = np.zeros(count, dtype=np.int64)
    ends: Int[::1] = np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        for j in range(starts[s], starts[s + 1]):
            home[j] = s
        ends[s + 1] = ends[s] + counts[starts[s + 1] - 1] - 1
    entries: Int = 0
    widest: Int = 0
    waiting: Int = 0
    room: Int = 0
    ready: Int[::1] = np.zeros(count, dtype=np.int64)  # entries that the children pass on
    for s in range(count):
        k, below = starts[s + 1] - starts[s], ends[s + 1] - ends[s]
        m = k + below
        entries += k * m - k * (k - 1) // 2
        widest = max(widest, m)
        room = max(room, waiting + m * (m + 1) // 2)
        passed = below * (below + 1) // 2
        waiting += passed - ready[s]
        if below > 0:
            above[s] = home[parent[starts[s + 1] - 1]]
            children[above[s]] += 1
            ready[above[s]] += passed
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
                s = above[s]
    return Supernodes(
        np.asarray(starts), np.asarray(children), np.asarray(ends), np.asarray(rows), entries, widest, room
    )


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
