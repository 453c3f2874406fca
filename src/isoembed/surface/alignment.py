"""Alignment of two placements of the same vertices by a rigid motion."""

import numpy as np

from isoembed.arrays import Floats


def aligned(vertices: Floats, onto: Floats) -> Floats:
    """Rotate and shift vertices, (V, 3), onto their other places, as near as least squares bring them.

    Kabsch, Acta Cryst. A32 (1976).
    """
    center = onto.mean(axis=0)
    x, y = vertices - vertices.mean(axis=0), onto - center
    left, _, right = np.linalg.svd(x.T @ y)
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return x @ (left @ proper @ right) + center


def distance(vertices: Floats, others: Floats) -> float:
    """The largest distance of a vertex from its other place, after the best rotation and translation."""
    return float(np.linalg.norm(aligned(vertices, others) - others, axis=1).max())
