"""An order of points in which neighbors in space are mostly neighbors in the list.

What walks through a large surface in this order finds most of what it needs in the processor's cache, however
the vertices are numbered.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from isoembed.arrays import Floats, Indices

MASKS = ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249))


def spatial_order(points: Floats) -> Indices:
    """Sort points along Morton's curve.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Finite.

    Returns
    -------
    ndarray of int, shape (n,)
        Each point once.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 1023 / ((high - low).max() or 1.0)
    keys = np.zeros(len(points), dtype=np.uint32)
    for axis in range(3):  # of the cube around the points, in 1024 cells
        bits = ((points[:, axis] - low[axis]) * scale).astype(np.uint32)
        for shift, mask in MASKS:  # moves the ten bits apart, to every third place
            bits = (bits | (bits << np.uint32(shift))) & np.uint32(mask)
        keys |= bits << np.uint32(axis)
    return np.argsort(keys, kind="stable")


@njit(cache=True)
def reordered(indptr: Indices, indices: Indices, order: Indices) -> tuple[Indices, Indices]:
    """Number the vertices of a graph in another order.

    Parameters
    ----------
    indptr, indices : ndarray of int, shapes (n + 1,), (m,)
        The neighbors of vertex i are ``indices[indptr[i]:indptr[i + 1]]``.
    order : ndarray of int, shape (n,)
        Each vertex once.

    Returns
    -------
    indptr, indices
        Of the graph in which vertex i is ``order[i]``.
    """
    place, starts = np.empty(len(order), dtype=indices.dtype), np.zeros(len(indptr), dtype=indptr.dtype)
    for i in range(len(order)):
        place[order[i]] = i
        starts[i + 1] = starts[i] + indptr[order[i] + 1] - indptr[order[i]]
    neighbors = np.empty_like(indices)
    for i in range(len(order)):
        for k in range(starts[i + 1] - starts[i]):
            neighbors[starts[i] + k] = place[indices[indptr[order[i]] + k]]
    return starts, neighbors
