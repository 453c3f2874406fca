# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Dense frontal matrices: partial factorization and assembly.

Of a front the upper triangle is kept, row after row: row j of m is m - j numbers, from the diagonal on. An
eliminated row is D times a column of L. It is followed by what is left for the rows below. The numbers are of
double or of single precision.
"""

from __future__ import annotations

from functools import partial

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, ConstReal, Int, Real
from cython.cimports.isoembed.linalg.blas import multiply_transposed
from cython.cimports.isoembed.linalg.prefetch import prefetch

from isoembed.threads import run_ranges

Number = cython.fused_type(cython.float, cython.double)
Stored = cython.fused_type(cython.float, cython.double)  # of L: those of fronts, or rounded

# columns whose products are subtracted from all rows below at once
BLOCK = cython.declare(cython.longlong, 256)
# rows and columns of a part of the product, which stays in the cache; little above the diagonal is multiplied
HEIGHT, WIDTH = cython.declare(cython.longlong, 128), cython.declare(cython.longlong, 1024)
# multiplications from which on threads share the parts: to wake one takes the time of a hundredth of them
SHARED = cython.declare(cython.longlong, 1 << 24)
AHEAD = cython.declare(cython.longlong, 2048)  # entries of L from its use on; larger factors wait for memory
# from so many columns on, and for so many rows below, a library multiplies faster
NARROW, SHORT = cython.declare(cython.longlong, 16), cython.declare(cython.longlong, 64)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def room_to_multiply(k: Int, m: Int) -> Int:
    """Entries of the array in which `eliminate_columns` multiplies matrices, for k of m columns."""
    wide = min(k, BLOCK)
    return 0 if k < NARROW else wide * (m + 1) + min(HEIGHT, m) * (wide + min(WIDTH, m))


def largest_room(nodes: object, first: Int, last: Int):
    """Entries of the array in which `eliminate` multiplies matrices, for supernodes between these."""
    starts: ConstInt[::1] = nodes.starts
    ends: ConstInt[::1] = nodes.ends
    size: Int = 0
    for s in range(first, last):
        k = starts[s + 1] - starts[s]
        size = max(size, room_to_multiply(k, k + ends[s + 1] - ends[s]))
    return size


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def beginning(j: Int, m: Int) -> Int:
    """Start of row j of a triangle of m rows."""
    return j * m - j * (j - 1) // 2


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def extend(front: Number[::1], m: Int, passed: Number[::1], places: Int[::1]) -> cython.void:
    """Add a triangle to a front of m rows, at these of its rows, which rise."""
    q = 0
    for a in range(places.shape[0]):
        row = beginning(places[a], m) - places[a]
        for b in range(a, places.shape[0]):
            front[row + places[b]] += passed[q]
            q += 1


@cython.ccall
@cython.nogil
@cython.exceptval(-1)
def eliminate_columns(front: Number[::1], k: Int, m: Int, least: Real, room: Number[::1]) -> cython.int:
    """Eliminate k of m columns; whether every pivot was larger than the least and not zero."""
    for first in range(0, k, 256):
        last = min(first + BLOCK, k)
        if last - first < NARROW or m - last < SHORT:
            if not _eliminate_few(front, first, last, m, m, least):
                return False
        elif not _eliminate_half(front, first, last, m, least, room):
            return False
        else:
            _subtract_products(front, first, last, last, m, m, room)
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(-1)
def _eliminate_half(
    front: Number[::1], first: Int, last: Int, m: Int, least: Real, room: Number[::1]
) -> cython.int:
    """Eliminate some columns from their own rows, the second half after what the first contributes to it."""
    if last - first <= NARROW:
        return _eliminate_few(front, first, last, m, last, least)
    middle = first + (last - first + 7) // 8 * 4
    if not _eliminate_half(front, first, middle, m, least, room):
        return False
    _subtract_products(front, first, middle, middle, last, m, room)
    return _eliminate_half(front, middle, last, m, least, room)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _eliminate_few(front: Number[::1], first: Int, last: Int, m: Int, end: Int, least: Real) -> cython.bint:
    """Eliminate some columns, four at a time, from themselves and from the rows below, up to `end`."""
    one: Number = 1.0
    zero: Number = 0.0
    for j0 in range(first, last, 4):
        j1 = min(j0 + 4, last)
        for j in range(j0, j1):
            at = beginning(j, m) - j
            pivot = front[at + j]
            if not (pivot > least and abs(pivot) > 0):
                return False
            for r in range(j + 1, j1):
                y = beginning(r, m)
                c: Number = front[at + r] / pivot
                for i in range(m - r):
                    front[y + i] -= c * front[at + r + i]
        # Where fewer than four are left, the last one stands for those missing, times zero.
        e1, e2, e3 = min(j0 + 1, j1 - 1), min(j0 + 2, j1 - 1), min(j0 + 3, j1 - 1)
        at0, at1 = beginning(j0, m) - j0, beginning(e1, m) - e1
        at2, at3 = beginning(e2, m) - e2, beginning(e3, m) - e3
        d0: Number = one / front[at0 + j0]
        d1: Number = (one if j0 + 1 < j1 else zero) / front[at1 + e1]
        d2: Number = (one if j0 + 2 < j1 else zero) / front[at2 + e2]
        d3: Number = (one if j0 + 3 < j1 else zero) / front[at3 + e3]
        for r in range(j1, end):
            y = beginning(r, m)
            c0: Number = front[at0 + r] * d0
            c1: Number = front[at1 + r] * d1
            c2: Number = front[at2 + r] * d2
            c3: Number = front[at3 + r] * d3
            for i in range(m - r):
                front[y + i] -= (
                    c0 * front[at0 + r + i]
                    + c1 * front[at1 + r + i]
                    + c2 * front[at2 + r + i]
                    + c3 * front[at3 + r + i]
                )
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(-1)
def _subtract_products(
    front: Number[::1], first: Int, last: Int, top: Int, bottom: Int, m: Int, room: Number[::1]
) -> cython.int:
    """Eliminate columns from the rows between top and bottom, by products of matrices."""
    k, width = last - first, m - top
    for j in range(k):  # the columns, then their inverse pivots
        at = beginning(first + j, m)
        room[k * width + j] = 1.0 / front[at]
        for i in range(width):
            room[j * width + i] = front[at + top - first - j + i]
    count = (bottom - top + HEIGHT - 1) // HEIGHT * ((width + WIDTH - 1) // WIDTH)
    if k * (bottom - top) * width < SHARED:
        for part in range(count):
            _subtract_part(front, k, top, bottom, m, room, room[k * (width + 1) :], part)
    else:
        with cython.gil:
            run_ranges(
                partial(subtract_parts, np.asarray(front), k, top, bottom, m, np.asarray(room)), count, 1
            )
    return 0


def subtract_parts(
    front: Number[::1], k: Int, top: Int, bottom: Int, m: Int, columns: Number[::1], parts: object
):
    """Subtract some parts of the product of k columns from the rows between top and bottom."""
    work: Number[::1] = np.empty((k + WIDTH) * HEIGHT, dtype=np.asarray(front).dtype)
    begin: Int = parts.start
    end: Int = parts.stop
    with cython.nogil:
        for part in range(begin, end):
            _subtract_part(front, k, top, bottom, m, columns, work, part)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _subtract_part(
    front: Number[::1],
    k: Int,
    top: Int,
    bottom: Int,
    m: Int,
    columns: Number[::1],
    work: Number[::1],
    part: Int,
) -> cython.void:
    """Subtract one part, of `HEIGHT` rows and `WIDTH` columns at most."""
    width = m - top
    across = (width + WIDTH - 1) // WIDTH
    r0, c0 = part // across * HEIGHT, part % across * WIDTH
    r1, c1 = min(r0 + HEIGHT, bottom - top), min(c0 + WIDTH, width)
    c0 = max(c0, r0)
    rows, wide = r1 - r0, c1 - c0
    if wide <= 0:
        return
    for j in range(k):
        for i in range(rows):
            work[j * rows + i] = columns[j * width + r0 + i] * columns[k * width + j]
    multiply_transposed(work, k, rows, columns[c0:], width, wide)
    for r in range(rows):
        y, z = beginning(top + r0 + r, m) - r0 - r + c0, k * rows + r * wide
        for i in range(max(0, r0 + r - c0), wide):
            front[y + i] -= work[z + i]


def eliminate(
    fronts: object,
    task: object,
    data: ConstReal[::1],
    L: Stored[::1],
    stack: Number[::1],
    room: Number[::1],
    least: Real,
):
    """Eliminate the supernodes of a task, and fill their part of L.

    Parameters
    ----------
    fronts : Fronts
    task : Task
    data : ndarray
        Entries of the matrix.
    L : ndarray
        Filled in.
    stack : ndarray
        Room for the fronts that wait. It begins with those that the task's children pass on, one after the
        other, and in the end with the one that the task passes on.
    room : ndarray
        Room for products of matrices.
    least : float

    Returns
    -------
    int
        The number of negative pivots, or -1 where one is zero or not larger than the least.
    """
    nodes = fronts.nodes
    indptr: ConstInt32[::1] = fronts.indptr
    indices: ConstInt32[::1] = fronts.indices
    starts: ConstInt[::1] = nodes.starts
    parents: ConstInt32[::1] = nodes.parents
    offsets: ConstInt[::1] = nodes.offsets
    ends: ConstInt[::1] = nodes.ends
    rows: ConstInt32[::1] = nodes.rows
    first: Int = task.first
    last: Int = task.last
    place: Int[::1] = np.empty(indptr.shape[0] - 1, dtype=np.int64)  # in the front, of its rows
    places: Int[::1] = np.empty(nodes.widest, dtype=np.int64)
    waiting: Int[::1] = np.empty(last - first + len(task.roots), dtype=np.int64)  # in the order of the stack
    front: Number[::1]
    waits: Int = 0
    top: Int = 0
    negative: Int = 0
    c: Int
    s: Int
    for c in task.roots:
        waiting[waits] = c
        waits += 1
        top += beginning(ends[c + 1] - ends[c], ends[c + 1] - ends[c])
    with cython.nogil:
        for s in range(first, last):
            k, below = starts[s + 1] - starts[s], ends[s + 1] - ends[s]
            m = k + below
            for i in range(k):
                place[starts[s] + i] = i
            for i in range(below):
                place[rows[ends[s] + i]] = k + i
            size = beginning(m, m)
            front = stack[top : top + size]
            front[:] = 0.0
            for j in range(k):
                at = beginning(j, m) - j
                for p in range(indptr[starts[s] + j], indptr[starts[s] + j + 1]):
                    front[at + place[indices[p]]] = data[p]
            bottom = top
            while waits > 0 and parents[waiting[waits - 1]] == s:
                waits -= 1
                c = waiting[waits]
                count = ends[c + 1] - ends[c]
                for i in range(count):
                    places[i] = place[rows[ends[c] + i]]
                extend(front, m, stack[bottom - beginning(count, count) : bottom], places[:count])
                bottom -= beginning(count, count)
            if not eliminate_columns(front, k, m, least, room):
                negative = -1
                break
            done = offsets[s]
            for j in range(k):
                at = beginning(j, m)
                pivot: Number = front[at]
                scale: Number = 1.0 / pivot
                negative += pivot < 0
                L[done] = pivot
                for i in range(1, m - j):
                    L[done + i] = front[at + i] * scale
                done += m - j
            at = beginning(k, m)
            for i in range(size - at):
                stack[bottom + i] = front[at + i]
            top = bottom + size - at
            waiting[waits] = s
            waits += 1
    return negative


def substitute_forward(nodes: object, task: object, L: Stored[::1], x: Number[:, ::1], tails: object):
    """Solve with D L for the columns of a task, in every row of x, (columns, n).

    Parameters
    ----------
    nodes : Supernodes
    task : Task
    L : ndarray
    x : ndarray
        Its part that belongs to the task is replaced.
    tails : sequence of ndarray
        What the task's children returned.

    Returns
    -------
    ndarray, shape (columns, rows)
        What is to be added to x in the rows below the last supernode of the task.
    """
    starts: ConstInt[::1] = nodes.starts
    offsets: ConstInt[::1] = nodes.offsets
    ends: ConstInt[::1] = nodes.ends
    rows: ConstInt32[::1] = nodes.rows
    first: Int = task.first
    last: Int = task.last
    v: Number[::1] = np.empty(nodes.widest, dtype=np.asarray(x).dtype)
    below_all: Int = ends[last] - ends[last - 1]
    tail: Number[:, ::1] = np.zeros((x.shape[0], below_all), dtype=np.asarray(x).dtype)
    place: Int[::1] = np.empty(x.shape[1], dtype=np.int64)  # in the tail, of its rows
    passed: Number[:, ::1]
    child: Int
    s: Int
    end: Int = starts[last]
    for i in range(below_all):
        place[rows[ends[last - 1] + i]] = i
    for child, array in zip(task.roots, tails):  # noqa: B905 -- in Cython `strict` costs a call
        passed = array
        for c in range(x.shape[0]):
            for i in range(passed.shape[1]):
                row = rows[ends[child] + i]
                if row < end:
                    x[c, row] += passed[c, i]
                else:
                    tail[c, place[row]] += passed[c, i]
    with cython.nogil:
        for s in range(first, last):
            own, k, below = starts[s], starts[s + 1] - starts[s], ends[s + 1] - ends[s]
            inside = below  # rows that belong to the task
            while inside > 0 and rows[ends[s] + inside - 1] >= end:
                inside -= 1
            for c in range(x.shape[0]):
                for i in range(k):
                    v[i] = x[c, own + i]
                for i in range(below):
                    v[k + i] = 0.0
                _forward(L, offsets[s], k, k + below, v, x, c, own)
                for i in range(inside):
                    x[c, rows[ends[s] + i]] += v[k + i]
                for i in range(inside, below):
                    tail[c, place[rows[ends[s] + i]]] += v[k + i]
    return np.asarray(tail)


def substitute_backward(nodes: object, task: object, L: Stored[::1], x: Number[:, ::1]):
    """Solve with the transpose of L for the columns of a task, in every row of x: those below are known."""
    starts: ConstInt[::1] = nodes.starts
    offsets: ConstInt[::1] = nodes.offsets
    ends: ConstInt[::1] = nodes.ends
    rows: ConstInt32[::1] = nodes.rows
    first: Int = task.first
    last: Int = task.last
    v: Number[::1] = np.empty(nodes.widest, dtype=np.asarray(x).dtype)
    s: Int
    with cython.nogil:
        for s in range(last - 1, first - 1, -1):
            own, k, below = starts[s], starts[s + 1] - starts[s], ends[s + 1] - ends[s]
            for c in range(x.shape[0]):
                for i in range(k):
                    v[i] = x[c, own + i]
                for i in range(below):
                    v[k + i] = x[c, rows[ends[s] + i]]
                _back(L, offsets[s], k, k + below, v)
                for i in range(k):
                    x[c, own + i] = v[i]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _forward(
    L: Stored[::1], start: Int, k: Int, m: Int, v: Number[::1], x: Number[:, ::1], row: Int, own: Int
) -> cython.void:
    """Solve with D L for the first k of m numbers, and subtract from the others what these contribute."""
    for j in range(0, k - k % 4, 4):  # four columns at once: v is read and written once for them
        a, b = start + beginning(j, m), start + beginning(j + 1, m)
        c, d = start + beginning(j + 2, m), start + beginning(j + 3, m)
        prefetch(L, a + AHEAD, a + AHEAD + 4 * (m - j))
        v0 = v[j]
        v1 = v[j + 1] - v0 * L[a + 1]
        v2 = v[j + 2] - v0 * L[a + 2] - v1 * L[b + 1]
        v3 = v[j + 3] - v0 * L[a + 3] - v1 * L[b + 2] - v2 * L[c + 1]
        for i in range(4, m - j):
            v[j + i] -= v0 * L[a + i] + v1 * L[b + i - 1] + v2 * L[c + i - 2] + v3 * L[d + i - 3]
        x[row, own + j] = v0 / L[a]
        x[row, own + j + 1] = v1 / L[b]
        x[row, own + j + 2] = v2 / L[c]
        x[row, own + j + 3] = v3 / L[d]
    for j in range(k - k % 4, k):
        a = start + beginning(j, m)
        for i in range(1, m - j):
            v[j + i] -= v[j] * L[a + i]
        x[row, own + j] = v[j] / L[a]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _back(L: Stored[::1], start: Int, k: Int, m: Int, v: Number[::1]) -> cython.void:
    """Solve with the transpose of L for the first k of m numbers, the others being known."""
    for j in range(k - 1, k - k % 4 - 1, -1):
        a = start + beginning(j, m)
        total: Number = 0.0
        for i in range(1, m - j):
            total += v[j + i] * L[a + i]
        v[j] -= total
    for j in range(k - k % 4 - 4, -1, -4):
        a, b = start + beginning(j, m), start + beginning(j + 1, m)
        c, d = start + beginning(j + 2, m), start + beginning(j + 3, m)
        prefetch(L, a - AHEAD, a - AHEAD + 4 * (m - j))
        t0: Number = 0.0
        t1: Number = 0.0
        t2: Number = 0.0
        t3: Number = 0.0
        for i in range(4, m - j):
            t0 += v[j + i] * L[a + i]
            t1 += v[j + i] * L[b + i - 1]
            t2 += v[j + i] * L[c + i - 2]
            t3 += v[j + i] * L[d + i - 3]
        v[j + 3] -= t3
        v[j + 2] -= t2 + v[j + 3] * L[c + 1]
        v[j + 1] -= t1 + v[j + 2] * L[b + 1] + v[j + 3] * L[b + 2]
        v[j] -= t0 + v[j + 1] * L[a + 1] + v[j + 2] * L[a + 2] + v[j + 3] * L[a + 3]
