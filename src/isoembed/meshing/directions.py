"""Directions that name given points of a surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_lattice
from isoembed.meshing.surface import Surface, spread_directions
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class DirectionsThresholds:
    """Thresholds of the search for directions."""

    samples: int = threshold(2000, "count", "Points of known direction: the search begins at the nearest.")
    steps: int = threshold(20, "count", "Newton steps from there.")
    missed: float = threshold(1e-12, "largest coordinate", "Distance at which a point is on the surface.")


DIRECTIONS = DirectionsThresholds()


def directions_of(surface: Surface, points: ArrayLike) -> Floats:
    """Directions (n, 3) that name points (n, 3) of a surface: the inverse of `Surface.point`.

    Raises
    ------
    ValueError
        A point is not on the surface.
    """
    x = np.asarray(points, dtype=np.float64) / surface._unit
    known = spread_directions(surface, fibonacci_lattice(DIRECTIONS.samples))
    u = known[cKDTree(surface._points(known)).query(x)[1]]
    size = float(np.abs(x).max(initial=0.0))
    for _ in range(DIRECTIONS.steps):
        missed, normals = x - surface._points(u), surface._normals(u)
        if np.abs(missed).max(initial=0.0) <= DIRECTIONS.missed * size:
            return u
        u = surface._moved(u, missed - np.einsum("ij,ij->i", missed, normals)[:, None] * normals)
    k = int(np.abs(missed).max(axis=1).argmax())
    raise ValueError(f"point {k}, {(surface._unit * x[k]).tolist()}, is not on {surface!r}")
