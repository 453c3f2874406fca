"""Triangle strips and fans, converted to triangles."""

import numpy as np

from isoembed.arrays import Indices


def strip_triangles(corners: Indices) -> Indices:
    """Consistently oriented triangles of a strip, shape (F, 3).

    Parameters
    ----------
    corners : ndarray of int, shape (n,)
        Each three consecutive vertices form a triangle, with alternating orientation; degenerate triangles,
        which repeat a vertex and join parts of a strip, are omitted.
    """
    triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def fan_triangles(corners: Indices) -> Indices:
    """Triangles around the first vertex, shape (F, 3)."""
    first = np.broadcast_to(corners[:1], len(corners) - 2)
    return np.stack([first, corners[1:-1], corners[2:]], axis=1)
