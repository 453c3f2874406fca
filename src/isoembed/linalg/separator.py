# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Minimal vertex separators by maximum flow in a band around a cut.

A cut parts a cell of a graph in two: the vertices on one side bear an even number, those on the other the
next.  The vertices within some hops of the cut are the band; of all sets of vertices of the band whose
removal leaves no way across, one of the smallest is found: by Menger's theorem it is as large as the number
of paths across that share no vertex.  The paths are found in phases of shortest ones (Dinic, Soviet Math.
Doklady 11, 1970).
"""

from __future__ import annotations

from typing import NamedTuple

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Int

from isoembed.arrays import Indices32

SEPARATOR = -1  # a vertex that parts two cells
FREE = cython.declare(cython.longlong, -1)  # a vertex on no path
END = cython.declare(cython.longlong, -2)  # the neighbor beyond the end of a path
LARGEST_SIDE = 0.8  # share of a cell: where a side would hold more, the band is not widened
_SEPARATOR = cython.declare(cython.longlong, SEPARATOR)
_LARGEST_SIDE = cython.declare(cython.double, LARGEST_SIDE)


class Graph(NamedTuple):
    """Compressed rows, int32, of a symmetric pattern."""

    indptr: Indices32
    indices: Indices32


@cython.cclass
class Pattern:
    """The arrays of a `Graph`."""

    def __init__(self, graph):
        self.indptr, self.indices = graph.indptr, graph.indices


@cython.cclass
class Band:
    """Working arrays for the flow, as long as the graph has vertices.

    A vertex v is two states, ``2 v`` where paths enter and ``2 v + 1`` where they leave.

    Attributes
    ----------
    members : ndarray of int64
        The vertices of the band in order of their layers.
    layer : ndarray of int64
        Hops from the cut; -1 outside the band.
    following, preceding : ndarray of int64
        The neighbors on the path through a vertex, `FREE` or `END`.
    level : ndarray of int64, two a vertex
        Steps from the source, -1 for states that it does not reach.
    trail : ndarray of int64, two a vertex
        States to visit.
    tried : ndarray of int64
        Place in ``indices`` of the next neighbor to try.
    """

    def __init__(self, n):
        self.members = np.zeros(n, dtype=np.int64)
        self.layer = np.full(n, -1, dtype=np.int64)
        self.following, self.preceding = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
        self.level, self.trail = np.zeros(2 * n, dtype=np.int64), np.zeros(2 * n, dtype=np.int64)
        self.tried = np.zeros(n, dtype=np.int64)


def separate(graph: Graph, members: Int[::1], cell: Int[::1], width: Int):
    """Replace a cut of a cell by a separator, as `replace_cut`."""
    return replace_cut(Pattern(graph), members, cell, width, Band(cell.shape[0]))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def replace_cut(
    graph: Pattern,
    members: cython.longlong[::1],
    cell: cython.longlong[::1],
    width: cython.longlong,
    band: Band,
) -> cython.longlong:
    """Replace a cut of a cell by a separator.

    Parameters
    ----------
    graph : Graph
    members : ndarray of int64
        The vertices of the cell.
    cell : ndarray of int64, shape (n,)
        An even number, or the next, for the vertices of the cell, other numbers for all others.  Changed: the
        two numbers for the sides, and `SEPARATOR`.
    width : int
        Layers beyond the ends of the severed edges on either side.  Where a band this wide leaves one side
        with more than `DissectionThresholds.largest_side` of the cell, only the ends themselves are taken.
    band : Band

    Returns
    -------
    int
        Number of vertices of the separator.
    """
    upper: Int = 0
    size: Int = 0
    v: Int
    for v in members:
        upper += cell[v] & 1
    # Of the smallest separators the one nearest to the source is found: the source is the larger side.
    larger = max(upper, members.shape[0] - upper)
    source: Int = (cell[members[0]] | 1) - (upper < larger)
    ends = _gather(graph, members, cell, band)
    while True:
        count = _widen(graph, cell, ends, width, band)
        _saturate(graph, cell, source, count, width, band)
        size = 0
        kept: Int = larger
        for k in range(count):
            v = band.members[k]
            reached: cython.bint = band.level[2 * v] >= 0
            passed: cython.bint = band.level[2 * v + 1] >= 0
            size += reached and not passed
            kept += passed
            kept -= cell[v] == source
        if width == 0 or max(kept, members.shape[0] - size - kept) <= _LARGEST_SIDE * members.shape[0]:
            break
        for k in range(ends, count):
            band.layer[band.members[k]] = -1
        width = 0
    for k in range(count):
        v = band.members[k]
        band.layer[v] = -1
        if band.level[2 * v + 1] >= 0:
            cell[v] = source
        elif band.level[2 * v] >= 0:
            cell[v] = _SEPARATOR
        else:
            cell[v] = source ^ 1
    return size


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gather(graph: Pattern, members: Int[::1], cell: Int[::1], band: Band) -> Int:
    """Begin the band with the ends of the severed edges; return their number."""
    count = 0
    for v in members:
        other = cell[v] ^ 1
        for p in range(graph.indptr[v], graph.indptr[v + 1]):
            if cell[graph.indices[p]] == other:
                band.members[count] = v
                band.layer[v] = 0
                count += 1
                break
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _widen(graph: Pattern, cell: Int[::1], ends: Int, width: Int, band: Band) -> Int:
    """Widen the band to this number of layers, and forget all paths; return its number of vertices."""
    count = ends
    head = 0
    while head < count:
        v = band.members[head]
        head += 1
        band.following[v] = band.preceding[v] = FREE
        if band.layer[v] == width:
            continue
        for p in range(graph.indptr[v], graph.indptr[v + 1]):
            u = graph.indices[p]
            if band.layer[u] < 0 and cell[u] | 1 == cell[v] | 1:
                band.layer[u] = band.layer[v] + 1
                band.members[count] = u
                count += 1
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _saturate(graph: Pattern, cell: Int[::1], source: Int, count: Int, width: Int, band: Band) -> cython.void:
    """Find paths from the outermost layer on the source's side to that on the other until there are no more.

    Afterwards ``level`` tells the states that can still be reached from the source.
    """
    while _rank(graph, cell, source, count, width, band):
        for k in range(count - 1, -1, -1):
            v = band.members[k]
            if band.layer[v] < width:
                break
            if cell[v] == source and band.level[2 * v] == 0:
                _advance(graph, cell, source, v, width, band)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _rank(graph: Pattern, cell: Int[::1], source: Int, count: Int, width: Int, band: Band) -> cython.bint:
    """Number the states by steps from the source, as far as the first across; return whether there is one."""
    for k in range(count):
        v = band.members[k]
        band.level[2 * v] = band.level[2 * v + 1] = -1
        band.tried[v] = graph.indptr[v]
    tail = 0
    for k in range(count - 1, -1, -1):
        v = band.members[k]
        if band.layer[v] < width:
            break
        if cell[v] == source:
            band.level[2 * v] = 0
            band.trail[tail] = 2 * v
            tail += 1
    across = -1
    head = 0
    while head < tail:
        state = band.trail[head]
        head += 1
        v = state >> 1
        step = band.level[state] + 1
        if across >= 0 and step > across:
            break
        if state & 1 == 0:
            leaving = _onward(v, band)
            if leaving >= 0 and band.level[leaving] < 0:
                band.level[leaving] = step
                band.trail[tail] = leaving
                tail += 1
            continue
        if band.layer[v] == width and cell[v] != source:
            across = band.level[state]
            continue
        if band.following[v] != FREE and band.level[2 * v] < 0:
            band.level[2 * v] = step
            band.trail[tail] = 2 * v
            tail += 1
        for p in range(graph.indptr[v], graph.indptr[v + 1]):
            u = graph.indices[p]
            if band.layer[u] >= 0 and band.level[2 * u] < 0 and u != band.following[v]:
                band.level[2 * u] = step
                band.trail[tail] = 2 * u
                tail += 1
    return across >= 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _onward(v: Int, band: Band) -> Int:
    """The state after entering v: leaving it, or leaving the vertex before it on the path it is on."""
    if band.following[v] == FREE:
        return 2 * v + 1
    return 2 * band.preceding[v] + 1 if band.preceding[v] >= 0 else -1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _advance(graph: Pattern, cell: Int[::1], source: Int, start: Int, width: Int, band: Band) -> cython.bint:
    """Add a path that begins at a vertex, if one runs along rising levels; states tried are crossed out."""
    trail, level = band.trail, band.level
    trail[0] = 2 * start
    top = 0
    while top >= 0:
        state = trail[top]
        v = state >> 1
        step = level[state] + 1
        onward = -1
        if state & 1 == 0:
            leaving = _onward(v, band)
            if leaving >= 0 and level[leaving] == step:
                onward = leaving
        elif band.layer[v] == width and cell[v] != source:
            break
        elif band.following[v] != FREE and level[2 * v] == step:
            onward = 2 * v
        else:
            while onward < 0 and band.tried[v] < graph.indptr[v + 1]:
                u = graph.indices[band.tried[v]]
                band.tried[v] += 1
                if band.layer[u] >= 0 and level[2 * u] == step and u != band.following[v]:
                    onward = 2 * u
        if onward >= 0:
            top += 1
            trail[top] = onward
        else:
            level[state] = -1
            top -= 1
    if top < 0:
        return False
    band.preceding[start] = END
    for k in range(top):
        here, there = trail[k], trail[k + 1]
        level[here] = -1
        if here & 1 == 1:
            v, u = here >> 1, there >> 1
            if u == v:
                band.following[v] = band.preceding[v] = FREE
            else:
                band.following[v], band.preceding[u] = u, v
    level[trail[top]] = -1
    band.following[trail[top] >> 1] = END
    return True
