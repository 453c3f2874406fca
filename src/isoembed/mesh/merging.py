"""Merging of coincident vertices."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components


def representatives(points: Floats, distance: float) -> Indices:
    """The first of the vertices that each is one with, shape (V,).

    Parameters
    ----------
    points : ndarray, shape (V, n)
        Finite.
    distance : float
        Vertices that are as near, or are connected by a chain of such, are one.  At 0 they are equal.
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
    order = np.lexsort(points.T)  # stable: of equal ones the first stays the first
    new = np.ones(len(points), dtype=bool)
    new[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    first = np.empty(len(points), dtype=np.int64)
    first[order] = order[new][np.cumsum(new) - 1]
    return first


def without_repetitions(corners: Indices, sizes: Indices) -> tuple[Indices, Indices, Mask]:
    """Faces without corners that repeat the one before, and without faces that are left with too few corners.

    Parameters
    ----------
    corners : ndarray of int, shape (n,)
        Vertices of the faces, one face after the other.
    sizes : ndarray of int, shape (F,)
        How many corners each face has: at least 1.

    Returns
    -------
    corners, sizes
        Of the faces that are left.
    left : ndarray of bool, shape (F,)
        Which these are: the others have fewer than three vertices, so they are edges or points.
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
    kept = differs & left[face]
    return corners[kept], np.bincount(face[kept], minlength=len(sizes))[left], left
