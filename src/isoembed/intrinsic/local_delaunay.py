"""Delaunay flips around a change, which keep some edges and remember a half-edge that leaves every vertex."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.intrinsic.flips import flip, is_delaunay, preceding

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

THIN = 1e-8  # height over longest side: the sides of a thinner triangle add up in floats


@njit(cache=True)
def half_edges_leaving(corners: Indices, n: int) -> Indices:
    """A half-edge that leaves each of n vertices, shape (n,); -1 where there is none."""
    leaving = np.full(n, -1, dtype=np.int64)
    for h in range(corners.size):
        leaving[corners[h]] = h
    return leaving


@njit(cache=True)
def flip_tracked(
    h: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
    thinnest: float,
) -> bool:
    """Flip an edge as `flip` does, and carry along which edges are kept and which half-edges leave."""
    t = twins[h]
    jk, im = h - 2 if h % 3 == 2 else h + 1, t - 2 if t % 3 == 2 else t + 1
    if not flip(h, corners, twins, lengths, directions, thinnest):
        return False
    kept[t], kept[h] = kept[jk], kept[im]
    kept[jk] = kept[im] = False
    leaving[corners[h]], leaving[corners[t]] = h, t
    leaving[corners[jk]], leaving[corners[im]] = jk, im
    return True


@njit(cache=True)
def restore_delaunay(
    stack: Indices,
    top: int,
    waiting: Mask,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
    weights: Floats,
) -> None:
    """Flip edges to Delaunay, beginning with those on a stack, except for those that are to be kept.

    Parameters
    ----------
    stack, waiting : ndarray, shape (3F,)
        Half-edges, and which of them are among the first `top` of the stack.
    top : int
    corners, twins, lengths, directions : ndarray, shape (3F,)
        Of `HalfEdges`.
    kept : ndarray of bool, shape (3F,)
    leaving : ndarray of int, shape (V,)
    weights : ndarray, shape (V,)
        Zeros.
    """
    limit = 100 * corners.size + 1000  # as in `flip_to_delaunay`
    while top > 0:
        top -= 1
        h = stack[top]
        waiting[h] = False
        if kept[h] or limit == 0 or is_delaunay(h, corners, twins, lengths, weights):
            continue
        t = twins[h]
        if not flip_tracked(h, corners, twins, lengths, directions, kept, leaving, THIN):
            continue
        limit -= 1
        for side in (h, preceding(h), t, preceding(t)):
            top = push(side, stack, top, waiting, twins)


@njit(cache=True)
def push(h: int, stack: Indices, top: int, waiting: Mask, twins: Indices) -> int:
    """Put an edge on the stack of `restore_delaunay`; return its new height."""
    name = min(h, twins[h])
    if not waiting[name]:
        stack[top] = name
        waiting[name] = True
        top += 1
    return top
