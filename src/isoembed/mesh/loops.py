# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled loops over triangulation tables: opposite half-edges, connected faces, pinched vertices."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, Flag, Int, Int32

Index = cython.fused_type(cython.int, cython.longlong)


@cython.cfunc
@cython.exceptval(check=False)
def following(h: Int) -> Int:
    return h - 2 if h % 3 == 2 else h + 1


def sorted_by_ends(corners: ConstInt[::1], n: Int):
    """Half-edges sorted by lower, then by higher endpoint, by two counting sorts."""
    before: Int32[::1] = np.arange(corners.shape[0]).astype(np.int32)
    after: Int32[::1] = np.empty(corners.shape[0], dtype=np.int32)
    for turn in range(2):
        lower: cython.bint = turn == 1
        starts: Int32[::1] = np.zeros(n + 1, dtype=np.int32)
        for h in range(corners.shape[0]):
            a, b = corners[h], corners[following(h)]
            starts[(min(a, b) if lower else max(a, b)) + 1] += 1
        for v in range(n):
            starts[v + 1] += starts[v]
        for k in range(corners.shape[0]):
            h = before[k]
            a, b = corners[h], corners[following(h)]
            v = min(a, b) if lower else max(a, b)
            after[starts[v]] = h
            starts[v] += 1
        before, after = after, before
    return np.asarray(before)


def pair(
    corners: ConstInt[::1],
    order: ConstInt32[::1],
    edges: Int[:, ::1],
    face_edges: Int[::1],
    edge_halfedges: Int[:, ::1],
    twins: Int32[::1],
):
    """Fill in the tables; return False if half-edges do not form pairs of opposite directions."""
    for e in range(edges.shape[0]):
        h, g = order[2 * e], order[2 * e + 1]
        a, b = corners[h], corners[following(h)]
        if a == b or corners[following(g)] != a:
            return False
        if a > b:
            h, g, a, b = g, h, b, a
        if e and edges[e - 1, 0] == a and edges[e - 1, 1] == b:
            return False
        edges[e, 0], edges[e, 1] = a, b
        edge_halfedges[e, 0], edge_halfedges[e, 1] = h, g
        face_edges[h], face_edges[g] = e, e
        twins[h], twins[g] = g, h
    return True


def reached_faces(twins: cython.const[Index][::1]):
    """Mask of faces connected to the first face across edges, shape (F,), from the half-edges' twins."""
    n_faces = twins.shape[0] // 3
    reached: Flag[::1] = np.zeros(n_faces, dtype=np.bool_)
    stack: Int32[::1] = np.empty(n_faces, dtype=np.int32)
    reached[0], stack[0] = True, 0
    waiting: Int = 1
    while waiting:
        waiting -= 1
        f = stack[waiting]
        for h in range(3 * f, 3 * f + 3):
            g = twins[h] // 3
            if not reached[g]:
                reached[g] = True
                stack[waiting] = g
                waiting += 1
    return np.asarray(reached)


def find(edges: ConstInt[:, ::1], n: Int, pairs: ConstInt[:, ::1]):
    """Row of each pair of endpoints in the table of edges, or -1."""
    e: Int
    end: Int
    middle: Int
    starts: Int[::1] = np.zeros(n + 1, dtype=np.int64)  # first edge with each lower endpoint
    for e in range(edges.shape[0]):
        starts[edges[e, 0] + 1] += 1
    for v in range(n):
        starts[v + 1] += starts[v]
    found: Int[::1] = np.full(pairs.shape[0], -1)
    for k in range(pairs.shape[0]):
        low, high = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if low < 0 or high >= n:
            continue
        e, end = starts[low], starts[low + 1]
        while e < end:
            middle = (e + end) // 2
            if edges[middle, 1] < high:
                e = middle + 1
            else:
                end = middle
        if e < starts[low + 1] and edges[e, 1] == high:
            found[k] = e
    return np.asarray(found)


def pinched(corners: ConstInt[::1], twins: ConstInt[::1], n: Int):
    """First vertex whose corners do not form a single fan; -1 if there is none."""
    degrees: Int[::1] = np.zeros(n, dtype=np.int64)
    first: Int[::1] = np.full(n, -1, dtype=np.int64)
    for h in range(corners.shape[0]):
        v = corners[h]
        degrees[v] += 1
        if first[v] < 0:
            first[v] = h
    for v in range(n):
        h = first[v]
        count = 0
        while count == 0 or h != first[v]:
            count += 1
            h = twins[h + 2 if h % 3 == 0 else h - 1]
        if count != degrees[v]:
            return v
    return -1
