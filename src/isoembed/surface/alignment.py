"""Alignment of two placements of the same points by a rigid motion."""

import numpy as np

from isoembed.arrays import Floats


def best_rotation(points: Floats, onto: Floats, weights: Floats | None = None) -> Floats:
    """The rotation R (3, 3) for which centered points (n, 3), as ``points @ R``, are nearest to others.

    The sum of squared distances is least, with weights (n,) where they are given.  Reflections are none.
    Kabsch, Acta Cryst. A32 (1976).
    """
    left, _, right = np.linalg.svd((points if weights is None else points * weights[:, None]).T @ onto)
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ proper @ right)


def aligned(vertices: Floats, onto: Floats) -> Floats:
    """Rotate and shift vertices, (V, 3), onto their other places, as near as least squares bring them."""
    center = onto.mean(axis=0)
    x = vertices - vertices.mean(axis=0)
    return x @ best_rotation(x, onto - center) + center


def distance(vertices: Floats, others: Floats) -> float:
    """The largest distance of a vertex from its other place, after the best rotation and translation."""
    return float(np.linalg.norm(aligned(vertices, others) - others, axis=1).max())
