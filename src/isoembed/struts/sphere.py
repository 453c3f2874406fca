"""Sphere through the hubs of a dome."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats


def sphere_through(points: Floats, tolerance: float) -> tuple[Floats, float] | None:
    """Center and radius of a sphere that contains points within a tolerance; None if there is none.

    The center is the linear least-squares solution of |x|^2 = 2 c . x + r^2 - |c|^2, about the mean.
    """
    mean = points.mean(axis=0)
    x = points - mean
    solution, _, rank, _ = np.linalg.lstsq(
        np.column_stack([2 * x, np.ones(len(x))]), (x * x).sum(axis=1), rcond=1e-9
    )
    if rank < 4:  # coplanar points
        return None
    center = solution[:3]
    distances = np.linalg.norm(x - center, axis=1)
    radius = float(distances.mean())
    if np.abs(distances - radius).max() > tolerance:
        return None
    return center + mean, radius
