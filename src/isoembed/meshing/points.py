"""Directions spread over a surface with a wanted density: points of a square, carried by its distribution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from isoembed.meshing.spreading import Cells

if TYPE_CHECKING:
    from isoembed.gallery.surface import Surface

Array = NDArray[np.float64]

CELLS = (1024, 256)
"""In theta and phi, where the density is sampled."""

CURVATURE_SHARE = 0.1
"""Vertices that follow the curvature, against one that follows the area."""


def vertex_density(surface: Surface, u: Array) -> Array:
    """Vertices per area (n,) that a surface asks for, up to a factor: 1 + share |K| A / 4 pi.

    One part of the vertices is spread over the area, the other over the absolute Gaussian curvature.
    int |K| dA does not depend on how sharp a tip is, so every tip gets its share at every sharpness
    and no tip starves the rest; a sphere stays uniform.
    """
    K, _ = surface._curvatures(u)
    return 1.0 + CURVATURE_SHARE * np.abs(K) * surface._radius**2


def _pole(surface: Surface) -> int:
    """Return the axis around which the surface is closest to round, z when in doubt."""
    extent = np.log(np.linalg.norm(surface._points(np.eye(3)), axis=1))
    spread = [abs(extent[(k + 1) % 3] - extent[(k + 2) % 3]) for k in (2, 1, 0)]
    return 2 - int(np.argmin(np.round(spread, 9)))


def spread_directions(surface: Surface, square: Array) -> Array:
    """Carry points of the unit square (n, 2) to directions (n, 3) with the :func:`vertex_density`."""

    def density(u: Array) -> Array:
        return np.asarray(surface._area_density(u) * vertex_density(surface, u))

    return Cells.of(density, CELLS, _pole(surface)).spread(square)
