# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Recursive bisection of a mesh, by separators of few vertices or cuts of few edges.

A cell of the graph is cut across its longest axis in coordinates of the vertices, where that severs few
edges; then the smallest separator near the cut is found.
"""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt32, ConstReal, Int, Real
from cython.cimports.isoembed.linalg.separator import Band, Pattern, replace_cut
from cython.cimports.libc.math import sqrt

from isoembed.arrays import Floats, Indices
from isoembed.linalg.separator import Graph
from isoembed.threads import run_ranges, taken

INF = cython.declare(cython.double, float("inf"))
WINDOW = cython.declare(
    cython.double, 0.25
)  # distance of a cut from the median of its cell, at most, in cells
PLACES = cython.declare(cython.longlong, 64)  # positions of a cut that are compared
SEPARATOR = cython.declare(cython.longlong, -1)  # a vertex that parts two cells


def separators(graph: Graph, position: Floats) -> tuple[Indices, Indices, Indices]:
    """Elimination order of the vertices of a graph by nested dissection, and where they are in its tree.

    Parameters
    ----------
    graph : Graph
        Planar or nearly so.
    position : ndarray, shape (n, 3)
        Coordinates in which neighbors are near.

    Returns
    -------
    order, path, depth : ndarray of int64, shape (n,)
        Binary digits of the path, as many as the depth, the highest first, tell the parts of the graph taken
        on the way to the cell of each vertex, or to the cell that it separates.
    """
    return _bisected(graph, position, True)


def bisection_paths(graph: Graph, position: Floats) -> Indices:
    """Cut a graph in two, where few edges are severed, and the parts in two, down to a few vertices.

    A cut runs along the smallest separator, whose vertices go to the side where they have more neighbors.
    Binary digits, the highest first and as many for every vertex, tell the parts taken on the way down, (n,).
    """
    _, paths, depths = _bisected(graph, position, False)
    return paths << (depths.max() - depths)


def lift_ends(indptr: ConstInt32[::1], indices: ConstInt32[::1], path: Int[::1], depth: Int[::1]):
    """Move an end of each edge of another graph that joins two parts into their separator; return the count.

    The deeper end goes.  Then every edge joins a vertex to one of the same cell, or of a separator above.
    """
    lifted = 0
    for v in range(path.shape[0]):
        for p in range(indptr[v], indptr[v + 1]):
            u = indices[p]
            if u >= v:
                continue
            level = min(depth[u], depth[v])
            a, b = path[u] >> (depth[u] - level), path[v] >> (depth[v] - level)
            if a == b:
                continue
            while a != b:
                a, b, level = a >> 1, b >> 1, level - 1
            w = v if depth[v] >= depth[u] else u
            path[w], depth[w] = a, level
            lifted += 1
    return lifted


def _bisected(graph: Graph, position: Floats, separated: bool) -> tuple[Indices, Indices, Indices]:
    """Return the vertices, both parts of a cell before the separator, if any, and their paths and depths."""
    n = len(position)
    cells = Cells(graph, position, separated)
    bands: list[Band] = []

    def bisect(start: int, end: int) -> None:
        band = taken(bands) or Band(n)
        if end - start <= max(n // 16, 8192):  # about 10 ms
            bisect_all(cells, start, end, band)
            bands.append(band)
            return
        parts = bisect_once(cells, start, end, band)
        bands.append(band)
        run_ranges(lambda some: [bisect(*parts[k]) for k in some], len(parts), 1)

    bisect(0, n)
    return cells.arrays()


@cython.cclass
class Cells:
    """The cells of a graph that are bisected: parts of an array of vertices.

    Cells in different parts may be bisected at once.  The number of a cell, in `cell`, is twice its beginning
    in the array, and only its own vertices bear it or the next.
    """

    pattern: Pattern
    position: ConstReal[:, ::1]
    separated: cython.bint
    order: Int[::1]
    members: Int[::1]
    cell: Int[::1]
    path: Int[::1]
    depth: Int[::1]
    height: Real[::1]
    heights: Real[::1]

    def __init__(self, graph, position, separated):
        n = len(position)
        self.pattern, self.position, self.separated = Pattern(graph), position, separated
        self.order, self.members = np.arange(n), np.empty(n, dtype=np.int64)
        self.cell, self.path, self.depth = np.zeros((3, n), dtype=np.int64)
        self.height, self.heights = np.empty((2, n))

    def arrays(self):
        """The vertices, and their paths and depths."""
        return np.asarray(self.order), np.asarray(self.path), np.asarray(self.depth)


def bisect_all(cells: Cells, start: Int, end: Int, band: Band):
    """Bisect a cell, and its parts, down to a few vertices."""
    table: Int[:, ::1] = np.empty((2, PLACES + 1), dtype=np.int64)
    sizes: Int[::1] = np.empty(2, dtype=np.int64)
    waiting: Int[:, ::1] = np.empty((2 + end - start, 2), dtype=np.int64)
    count: Int = 1
    waiting[0, 0], waiting[0, 1] = start, end
    with cython.nogil:
        while count > 0:
            count -= 1
            start, end = waiting[count, 0], waiting[count, 1]
            if end - start <= 4:  # cutting smaller cells saves hardly any fill
                continue
            if _bisect(cells, start, end, band, table, sizes):
                middle = start + sizes[0]
                waiting[count, 0], waiting[count, 1] = start, middle
                waiting[count + 1, 0], waiting[count + 1, 1] = middle, middle + sizes[1]
                count += 2


def bisect_once(cells: Cells, start: Int, end: Int, band: Band):
    """Bisect a cell; return the beginnings and ends of its parts, if there are two."""
    table: Int[:, ::1] = np.empty((2, PLACES + 1), dtype=np.int64)
    sizes: Int[::1] = np.empty(2, dtype=np.int64)
    with cython.nogil:
        done = _bisect(cells, start, end, band, table, sizes)
    middle = start + sizes[0]
    return [(start, middle), (middle, middle + sizes[1])] if done else []


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _bisect(
    cells: Cells, start: Int, end: Int, band: Band, table: Int[:, ::1], sizes: Int[::1]
) -> cython.bint:
    """Bisect a cell and set the sizes of both parts; False if one would be empty."""
    v: Int
    order, cell, size = cells.order, cells.cell, end - start
    these: Int[::1] = cells.members[start:end]
    for k in range(size):
        these[k] = order[start + k]
    _measure(these, cells.position, cells.height)
    _cut(cells.pattern, these, cell, cells.height, cells.heights[start:end], table)
    # a band of .05 sqrt(size) layers on either side, at most six
    width: Int = min(cython.cast(Int, 0.05 * sqrt(size)), 6)
    replace_cut(cells.pattern, these, cell, width, band)
    if not cells.separated:
        _dissolve(cells.pattern, these, cell)
    lower: Int = 0
    upper: Int = 0
    for k in range(size):
        v = these[k]
        if cell[v] != SEPARATOR:
            lower += 1 - (cell[v] & 1)
            upper += cell[v] & 1
    if max(lower, upper) == size:
        return False
    sizes[0], sizes[1] = lower, upper
    a, b, c = start, start + lower, start + lower + upper
    for k in range(size):
        v = these[k]
        if cell[v] == SEPARATOR:
            order[c] = v
            c += 1
            continue
        cells.depth[v] += 1
        cells.path[v] = 2 * cells.path[v] + (cell[v] & 1)
        if cell[v] & 1 == 0:
            order[a] = v
            a += 1
            cell[v] = 2 * start
        else:
            order[b] = v
            b += 1
            cell[v] = 2 * (start + lower)
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _measure(members: Int[::1], position: ConstReal[:, ::1], height: Real[::1]) -> cython.void:
    """Set `height` of the vertices of a cell: their coordinate along its longest axis."""
    x: Real
    y: Real
    z: Real
    xx: Real
    xy: Real
    xz: Real
    yy: Real
    yz: Real
    zz: Real
    a: Real
    b: Real
    c: Real
    trace: Real
    x = y = z = 0.0
    for v in members:
        x += position[v, 0]
        y += position[v, 1]
        z += position[v, 2]
    x /= members.shape[0]
    y /= members.shape[0]
    z /= members.shape[0]
    xx = xy = xz = yy = yz = zz = 0.0
    for v in members:
        a, b, c = position[v, 0] - x, position[v, 1] - y, position[v, 2] - z
        xx += a * a
        xy += a * b
        xz += a * c
        yy += b * b
        yz += b * c
        zz += c * c
    # Squares of the matrix of moments, until the longest axis is left; its longest column then is that axis.
    for _ in range(5):
        trace = xx + yy + zz
        if trace <= 0:
            break
        xx, xy, xz, yy, yz, zz = (xx / trace, xy / trace, xz / trace, yy / trace, yz / trace, zz / trace)
        xx, xy, xz, yy, yz, zz = (
            xx * xx + xy * xy + xz * xz,
            xx * xy + xy * yy + xz * yz,
            xx * xz + xy * yz + xz * zz,
            xy * xy + yy * yy + yz * yz,
            xy * xz + yy * yz + yz * zz,
            xz * xz + yz * yz + zz * zz,
        )
    if xx >= yy and xx >= zz:
        a, b, c = xx, xy, xz
    elif yy >= zz:
        a, b, c = xy, yy, yz
    else:
        a, b, c = xz, yz, zz
    for v in members:
        height[v] = a * position[v, 0] + b * position[v, 1] + c * position[v, 2]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cut(
    graph: Pattern,
    members: Int[::1],
    cell: Int[::1],
    height: Real[::1],
    heights: Real[::1],
    table: Int[:, ::1],
) -> cython.void:
    """Cut a cell at a height near the median that severs little: numbers above it become odd.

    ``heights`` and ``table``, (2, places + 1), are room to work in.
    """
    size = members.shape[0]
    for k in range(size):
        heights[k] = height[members[k]]
    low = _selected(heights, cython.cast(Int, (0.5 - WINDOW) * size))
    high = _selected(heights, cython.cast(Int, (0.5 + WINDOW) * size))
    if not low < high:
        _halve(members, cell, height, low)
        return
    # Bin 0 is below low, bins 1, 2, .. lie between low and high.
    bins = min(PLACES, max(4, size // 4))
    scale = bins / (high - low)
    inside, change = table[0], table[1]  # vertices in a bin, and severed edges above it less those below
    for b in range(bins + 1):
        inside[b] = change[b] = 0
    for v in members:
        if height[v] < low:
            inside[0] += 1
        elif height[v] <= high:
            here = min(cython.cast(Int, (height[v] - low) * scale) + 1, bins)
            inside[here] += 1
            for p in range(graph.indptr[v], graph.indptr[v + 1]):
                u = graph.indices[p]
                if cell[u] == cell[v]:
                    if height[u] > height[v]:
                        there = min(cython.cast(Int, (min(height[u], high) - low) * scale) + 1, bins)
                        change[here] += 1
                        change[there] -= 1
                    elif height[u] < low:
                        change[0] += 1
                        change[here] -= 1
    least, best = INF, 0
    below: Int = 0
    severed: Int = 0
    for b in range(bins):
        below += inside[b]
        severed += change[b]
        # the factor 2 weighs balance against severed edges
        share = 1.0 * below / size - 0.5
        cost = (severed + 1) * (1 + 2.0 * share * share)
        if below > 0 and cost < least:
            least, best = cost, b
    level = low + best / scale
    for v in members:
        cell[v] += height[v] >= level


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _halve(members: Int[::1], cell: Int[::1], height: Real[::1], level: Real) -> cython.void:
    """Cut a cell at a height that many vertices have: these one by one, until the halves are equal."""
    left: Int = members.shape[0] // 2
    for v in members:
        left -= height[v] < level
    for v in members:
        if height[v] == level and left > 0:
            left -= 1
        elif height[v] >= level:
            cell[v] += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _dissolve(graph: Pattern, members: Int[::1], cell: Int[::1]) -> cython.void:
    """Put every vertex of a separator on the side where it has more neighbors."""
    odd: Int = 1
    for v in members:
        if cell[v] != SEPARATOR:
            odd = cell[v] | 1
    for v in members:
        if cell[v] == SEPARATOR:
            excess: Int = 0
            for p in range(graph.indptr[v], graph.indptr[v + 1]):
                side = cell[graph.indices[p]]
                excess += side == odd
                excess -= side == odd - 1
            cell[v] = odd - (excess < 0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _selected(values: Real[::1], k: Int) -> Real:
    """The k-th smallest value, from 0; the values are moved about (Hoare, Find, Comm. ACM 4, 1961)."""
    first: Int = 0
    last: Int = values.shape[0] - 1
    while first < last:
        pivot = values[(first + last) // 2]
        i, j = first, last
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if k <= j:
            last = j
        elif k >= i:
            first = i
        else:
            break
    return values[k]


def breadth_first(graph: Graph, start: Int):
    """The vertices that a path leads to, in order of their distance from one, and the distances, (n,).

    They count edges, and are -1 where there is no path.
    """
    indptr: ConstInt32[::1] = graph.indptr
    indices: ConstInt32[::1] = graph.indices
    n = indptr.shape[0] - 1
    order: Int[::1] = np.empty(n, dtype=np.int64)
    hops: Int[::1] = np.full(n, -1, dtype=np.int64)
    order[0], hops[start] = start, 0
    head: Int = 0
    tail: Int = 1
    while head < tail:
        v = order[head]
        head += 1
        for p in range(indptr[v], indptr[v + 1]):
            u = indices[p]
            if hops[u] < 0:
                hops[u] = hops[v] + 1
                order[tail] = u
                tail += 1
    return np.asarray(order[:tail]), np.asarray(hops)


def smoothed(graph: Graph, position: ConstReal[:, ::1]):
    """Averages over every vertex and its neighbors."""
    indptr: ConstInt32[::1] = graph.indptr
    indices: ConstInt32[::1] = graph.indices
    average: Real[:, ::1] = np.array(position)
    for v in range(position.shape[0]):
        for p in range(indptr[v], indptr[v + 1]):
            for c in range(3):
                average[v, c] += position[indices[p], c]
        for c in range(3):
            average[v, c] /= 1 + indptr[v + 1] - indptr[v]
    return np.asarray(average)
