"""Directions (points of the unit sphere) of given surface points."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_lattice
from isoembed.meshing.surface import Surface, spread_directions


def directions_of(surface: Surface, points: ArrayLike) -> Floats:
    """Directions (n, 3) of points (n, 3) of a surface: inverse of `Surface.point`.

    Raises
    ------
    ValueError
        A point is not on the surface.
    """
    x = np.asarray(points, dtype=np.float64) / surface._unit
    # Newton's method starts at the nearest point of known direction
    samples = spread_directions(surface, fibonacci_lattice(2000))
    u = samples[cKDTree(surface._points(samples)).query(x)[1]]
    size = float(np.abs(x).max(initial=0.0))
    for _ in range(20):  # Newton steps
        residuals, normals = x - surface._points(u), surface._normals(u)
        if np.abs(residuals).max(initial=0.0) <= 1e-12 * size:  # the point is on the surface
            return u
        u = surface._moved(u, residuals - np.einsum("ij,ij->i", residuals, normals)[:, None] * normals)
    k = int(np.abs(residuals).max(axis=1).argmax())
    raise ValueError(f"point {k}, {(surface._unit * x[k]).tolist()}, is not on {surface!r}")
