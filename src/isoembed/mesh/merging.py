"""Merging of coincident vertices."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components


def representatives(points: Floats, distance: float) -> Indices:
    """Index of the first vertex merged with each vertex, shape (V,).

    Parameters
    ----------
    points : ndarray, shape (V, n)
        Finite coordinates.
    distance : float
        Vertices connected by a chain of distances up to this are merged; at 0, equal ones.
    """
    if distance == 0:
        return _of_equals(points)
    from scipy.spatial import cKDTree  # slow to import, and seldom needed

    n = len(points)
    exponent = int(np.frexp(np.abs(points).max(initial=0.0))[1])  # the tree squares coordinates
    tree = cKDTree(np.ldexp(points, -exponent))
    a, b = tree.query_pairs(float(np.ldexp(distance, -exponent)), output_type="ndarray").T
    label = components(a, b, n)
    return np.unique(label, return_index=True)[1][label]


def _of_equals(points: Floats) -> Indices:
    order = np.lexsort(points.T)  # stable: the first of equal vertices stays first
    new = np.ones(len(points), dtype=bool)
    new[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    first = np.empty(len(points), dtype=np.int64)
    first[order] = order[new][np.cumsum(new) - 1]
    return first


def without_repetitions(corners: Indices, sizes: Indices) -> tuple[Indices, Indices, Mask]:
    """Remove corners equal to the preceding one, and faces with fewer than three distinct vertices.

    Parameters
    ----------
    corners : ndarray of int, shape (n,)
        Concatenated vertices of the faces.
    sizes : ndarray of int, shape (F,)
        Number of corners of each face, at least 1.

    Returns
    -------
    corners, sizes
        Corners and sizes of the remaining faces.
    left : ndarray of bool, shape (F,)
        Mask of remaining faces; the others degenerate to edges or points.
    """
    ends = np.cumsum(sizes)
    before = np.arange(-1, len(corners) - 1)
    before[ends - sizes] = ends - 1
    differs = corners != corners[before]
    if differs.all() and (sizes == 3).all():
        return corners, sizes, np.ones(len(sizes), dtype=bool)
    face = np.repeat(np.arange(len(sizes)), sizes)
    n = int(corners.max()) + 1
    pairs = np.sort(face * n + corners)
    distinct = pairs[np.insert(pairs[1:] != pairs[:-1], 0, True)]
    left = np.bincount(distinct // n, minlength=len(sizes)) >= 3
    selected = differs & left[face]
    return corners[selected], np.bincount(face[selected], minlength=len(sizes))[left], left
