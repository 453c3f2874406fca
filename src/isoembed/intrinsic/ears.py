"""Triangulation of a simple polygon: ear clipping, then constrained Delaunay flips."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.ear_loops import Constrained, clip_ears
from isoembed.intrinsic.loops import flip_edges


def triangulated(points: Floats) -> Indices | None:
    """Triangles of the constrained Delaunay triangulation of a polygon.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Corners of a simple polygon, counterclockwise, with coordinates of at most order 1; some may be
        collinear.

    Returns
    -------
    ndarray of int64, shape (n - 2, 3), or None
        Counterclockwise triangles.  None if the polygon is so thin that its triangles degenerate by rounding.

    References
    ----------
    Meisters, Polygons have ears, American Mathematical Monthly 82 (1975).
    """
    triangles = np.empty((len(points) - 2, 3), dtype=np.int64)
    if not clip_ears(points, triangles):
        return None
    twins = twins_inside(triangles)
    outline = np.flatnonzero(twins < 0)
    twins[outline] = twins.size + np.arange(outline.size)
    flip_edges(
        np.arange(triangles.size), Constrained(triangles.ravel(), np.concatenate([twins, outline]), points)
    )
    return triangles


def twins_inside(triangles: Indices) -> Indices:
    """Twins of the half-edges, (3F,) for triangles (F, 3); -1 on the outline."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    order = np.lexsort([high, low])
    first, second = order[:-1], order[1:]
    same = (low[first] == low[second]) & (high[first] == high[second])
    twins = np.full(len(ends), -1)
    twins[first[same]], twins[second[same]] = second[same], first[same]
    return twins
