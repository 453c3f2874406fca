"""Dense symmetric matrices, the fronts, in which the first columns are eliminated.

Of a front the upper triangle is kept, row after row: row j of m is m - j numbers, from the diagonal on. An
eliminated row is D times a column of L. It is followed by what is left for the rows below. The numbers are of
double or of single precision.
"""

import numpy as np

from isoembed.arrays import Floats, Indices, Singles
from isoembed.kernel import kernel

_BLOCK = 64  # rows whose multiples are taken from those below at once
_NARROW, _SHORT = 16, 64  # from so many of them on, and for so many rows below, a library multiplies faster


@kernel
def room_to_multiply(front: Floats | Singles, m: int) -> Floats | Singles:
    """Room that `eliminate_columns` works in, for fronts like this of up to m rows."""
    return np.empty(3 * _BLOCK * m, dtype=front.dtype)


@kernel
def beginning(j: int, m: int) -> int:
    """Where row j of a triangle of m rows begins."""
    return j * m - j * (j - 1) // 2


@kernel
def extend(front: Floats | Singles, m: int, passed: Floats | Singles, places: Indices) -> None:
    """Add a triangle to a front of m rows, at these of its rows, which rise."""
    q = 0
    for a in range(places.size):
        row = front[beginning(places[a], m) - places[a] :]
        for b in range(a, places.size):
            row[places[b]] += passed[q]
            q += 1


@kernel
def eliminate_columns(front: Floats | Singles, k: int, m: int, least: float, room: Floats | Singles) -> bool:
    """Eliminate k of m columns; whether every pivot was larger than the least and not zero."""
    for first in range(0, k, _BLOCK):
        last = min(first + _BLOCK, k)
        by_library = last - first >= _NARROW and m - last >= _SHORT
        if not _eliminate_block(front, first, last, m, last if by_library else m, least):
            return False
        if by_library:
            _subtract_products(front, first, last, m, room)
    return True


@kernel(fastmath={"contract"})
def _eliminate_block(front: Floats | Singles, first: int, last: int, m: int, end: int, least: float) -> bool:
    """Eliminate some columns, four at a time, from themselves and from the rows below, up to `end`."""
    for j0 in range(first, last, 4):
        j1 = min(j0 + 4, last)
        for j in range(j0, j1):
            at = beginning(j, m) - j
            pivot = front[at + j]
            if not (pivot > least and abs(pivot) > 0):
                return False
            for r in range(j + 1, j1):
                y, a = front[beginning(r, m) : beginning(r + 1, m)], front[at + r : at + m]
                c = a[0] / pivot
                for i in range(y.size):
                    y[i] -= c * a[i]
        # Where fewer than four are left, the last one stands for those missing, times zero.
        e1, e2, e3 = min(j0 + 1, j1 - 1), min(j0 + 2, j1 - 1), min(j0 + 3, j1 - 1)
        at0, at1, at2, at3 = (
            beginning(j0, m) - j0,
            beginning(e1, m) - e1,
            beginning(e2, m) - e2,
            beginning(e3, m) - e3,
        )
        one = front[at0 + j0] / front[at0 + j0]  # of the precision of the front
        zero = one - one
        d0, d1 = one / front[at0 + j0], (one if j0 + 1 < j1 else zero) / front[at1 + e1]
        d2 = (one if j0 + 2 < j1 else zero) / front[at2 + e2]
        d3 = (one if j0 + 3 < j1 else zero) / front[at3 + e3]
        for r in range(j1, end):
            y = front[beginning(r, m) : beginning(r + 1, m)]
            a0, a1 = front[at0 + r : at0 + m], front[at1 + r : at1 + m]
            a2, a3 = front[at2 + r : at2 + m], front[at3 + r : at3 + m]
            c0, c1, c2, c3 = a0[0] * d0, a1[0] * d1, a2[0] * d2, a3[0] * d3
            for i in range(y.size):
                y[i] -= c0 * a0[i] + c1 * a1[i] + c2 * a2[i] + c3 * a3[i]
    return True


@kernel
def _subtract_products(
    front: Floats | Singles, first: int, last: int, m: int, room: Floats | Singles
) -> None:
    """Eliminate a block of columns from all rows below, by products of matrices."""
    k, below = last - first, m - last
    part = below * k
    columns, scaled = room[:part].reshape(below, k), room[part : 2 * part].reshape(below, k)
    for j in range(k):
        at = beginning(first + j, m) - first - j
        factor = 1.0 / front[at + first + j]
        for i in range(below):
            columns[i, j] = front[at + last + i]
            scaled[i, j] = front[at + last + i] * factor
    for top in range(0, below, _BLOCK):
        bottom, width = min(top + _BLOCK, below), below - top
        product = room[2 * part : 2 * part + (bottom - top) * width].reshape(bottom - top, width)
        np.dot(scaled[top:bottom], columns[top:].T, product)
        for r in range(bottom - top):
            y = front[beginning(last + top + r, m) : beginning(last + top + r + 1, m)]
            for i in range(y.size):
                y[i] -= product[r, r + i]
