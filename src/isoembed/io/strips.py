"""Triangle strips and fans, converted to triangles."""

import numpy as np

from isoembed.arrays import Indices


def strip_triangles(corners: Indices) -> Indices:
    """Triangles of a strip, all turned alike, shape (F, 3).

    Parameters
    ----------
    corners : ndarray of int, shape (n,)
        Each three in a row are a triangle, every other turned around; those that repeat a vertex join parts
        of a strip and are none.
    """
    triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def fan_triangles(corners: Indices) -> Indices:
    """Triangles around the first vertex, shape (F, 3)."""
    first = np.broadcast_to(corners[:1], len(corners) - 2)
    return np.stack([first, corners[1:-1], corners[2:]], axis=1)
