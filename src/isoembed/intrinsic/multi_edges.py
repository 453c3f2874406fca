"""Flips that leave no two edges with the same two ends, so that triangles become a simplicial complex."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.intrinsic.flips import HalfEdges, preceding
from isoembed.intrinsic.local_delaunay import THIN, flip_tracked, half_edges_leaving

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]


def repeated(tables: HalfEdges) -> Indices:
    """Edges that are loops or have the same two ends as another, as the lower of their half-edges."""
    h = np.flatnonzero(np.arange(tables.twins.size) < tables.twins)
    a, b = tables.corners[h], tables.corners[tables.twins[h]]
    n = int(tables.corners.max()) + 1
    _, pair, count = np.unique(
        np.minimum(a, b) * n + np.maximum(a, b), return_inverse=True, return_counts=True
    )
    return h[(a == b) | (count[pair] > 1)]


def remove_multi_edges(tables: HalfEdges, kept: Mask) -> None:
    """Flip edges in place until no two have the same two ends and none is a loop, as far as that succeeds.

    Parameters
    ----------
    tables : HalfEdges
    kept : ndarray of bool, shape (3F,)
        Half-edges of edges that are not to be flipped; carried along.
    """
    edges = repeated(tables)
    if edges.size == 0:
        return
    leaving = half_edges_leaving(tables.corners, int(tables.corners.max()) + 1)
    flips = 1
    while edges.size and flips:
        flips = _separate(
            edges, tables.corners, tables.twins, tables.lengths, tables.directions, kept, leaving
        )
        edges = repeated(tables)


@njit(cache=True)
def _separate(
    edges: Indices,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
) -> int:
    """Flip those of the edges that still are repeated."""
    flips = 0
    for h in edges:
        if kept[h] or not _is_repeated(h, corners, twins):
            continue
        if _turn(h, corners, twins, lengths, directions, kept, leaving):
            flips += 1
    return flips


@njit(cache=True)
def _turn(
    h: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
) -> bool:
    """Flip an edge, if no other joins the two vertices that it is going to join."""
    k, m = preceding(h), preceding(twins[h])
    if corners[k] == corners[m] or _edges_between(k, corners[m], corners, twins) > 0:
        return False
    return flip_tracked(h, corners, twins, lengths, directions, kept, leaving, THIN)


@njit(cache=True)
def _is_repeated(h: int, corners: Indices, twins: Indices) -> bool:
    a, b = corners[h], corners[twins[h]]
    return a == b or _edges_between(h, b, corners, twins) > 1


@njit(cache=True)
def _edges_between(h: int, v: int, corners: Indices, twins: Indices) -> int:
    """How many edges lead from the vertex that a half-edge leaves to v."""
    found = 0
    e = h
    while True:
        if corners[twins[e]] == v:
            found += 1
        e = twins[preceding(e)]
        if e == h:
            return found
