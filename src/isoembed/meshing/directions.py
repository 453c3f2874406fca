"""From points of a surface back to the directions that name them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from isoembed.meshing.points import spread_directions
from isoembed.meshing.sphere import fibonacci_lattice

if TYPE_CHECKING:
    from isoembed.gallery.surface import Surface

Array = NDArray[np.float64]

SAMPLES = 2000  # points of known direction, to begin at the nearest
NEWTON = 20  # steps from there
ON_THE_SURFACE = 1e-12  # of the largest coordinate


def directions_of(surface: Surface, points: ArrayLike) -> Array:
    """The directions (n, 3) that name points (n, 3) of a surface: the inverse of `Surface.point`.

    Raises
    ------
    ValueError
        A point is not on the surface.
    """
    x = np.asarray(points, dtype=np.float64) / surface._unit
    known = spread_directions(surface, fibonacci_lattice(SAMPLES))
    u = known[cKDTree(surface._points(known)).query(x)[1]]
    size = float(np.abs(x).max(initial=0.0))
    for _ in range(NEWTON):
        missed, normals = x - surface._points(u), surface._normals(u)
        if np.abs(missed).max(initial=0.0) <= ON_THE_SURFACE * size:
            return u
        u = surface._moved(u, missed - np.einsum("ij,ij->i", missed, normals)[:, None] * normals)
    k = int(np.abs(missed).max(axis=1).argmax())
    raise ValueError(f"point {k}, {(surface._unit * x[k]).tolist()}, is not on {surface!r}")
