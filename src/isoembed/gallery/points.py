"""Directions spread over a surface with a wanted density: points of a square, carried by its distribution."""

import numpy as np
from numpy.typing import NDArray

from isoembed.gallery.surface import Surface

Array = NDArray[np.float64]

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


def fibonacci_lattice(n: int) -> Array:
    """Return n points (n, 2) spread evenly over the unit square, whose second coordinate is periodic."""
    i = np.arange(n)
    return np.stack([(i + 0.5) / n, i * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0], axis=1)


def _pole(surface: Surface) -> int:
    """Return the axis around which the surface is closest to round, z when in doubt."""
    extent = np.log(np.linalg.norm(surface._points(np.eye(3)), axis=1))
    spread = [abs(extent[(k + 1) % 3] - extent[(k + 2) % 3]) for k in (2, 1, 0)]
    return 2 - int(np.argmin(np.round(spread, 9)))


def _directions(mu: Array, phi: Array, pole: int) -> Array:
    """Return the unit vectors at height mu along the axis ``pole`` and angle phi around it."""
    sin = np.sqrt(1.0 - mu**2)
    u = np.stack(np.broadcast_arrays(sin * np.cos(phi), sin * np.sin(phi), mu), axis=-1)
    return np.roll(u, pole - 2, axis=-1)


def spread_directions(surface: Surface, square: Array) -> Array:
    """Carry points of the unit square (n, 2) to directions (n, 3) whose points have :func:`vertex_density`.

    Points that are even in the square come out with the density: the inverse of the marginal distribution
    in the height and of the conditional distribution in the angle carries them to the sphere of directions.
    """
    pole = _pole(surface)
    theta = np.linspace(0.0, np.pi, 1025)
    phi = np.linspace(0.0, 2.0 * np.pi, 257)
    # Half-way between the nodes: each value stands for its cell.
    middle_theta, middle_phi = 0.5 * (theta[1:] + theta[:-1]), 0.5 * (phi[1:] + phi[:-1])
    grid = _directions(np.cos(middle_theta)[:, None], middle_phi[None, :], pole).reshape(-1, 3)
    cells = (surface._area_density(grid) * vertex_density(surface, grid)).reshape(len(middle_theta), -1)
    cells *= -np.diff(np.cos(theta))[:, None]

    marginal = np.concatenate([[0.0], np.cumsum(cells.sum(axis=1))])
    heights, turns = square.T
    theta_i = np.interp(heights, marginal / marginal[-1], theta)
    # The conditional distribution of the point's own height: a blend of the two nearest rows.
    row = np.interp(theta_i, middle_theta, np.arange(len(middle_theta)))
    low = np.minimum(row.astype(np.int64), len(middle_theta) - 2)
    conditional = np.cumsum(cells / cells.sum(axis=1)[:, None], axis=1)
    conditional = np.concatenate([np.zeros((len(conditional), 1)), conditional], axis=1)
    phi_i = np.empty(len(square))
    for chunk in np.array_split(np.arange(len(square)), max(1, len(square) // 4096)):
        blend = (row - low)[chunk, None]
        F = (1.0 - blend) * conditional[low[chunk]] + blend * conditional[low[chunk] + 1]
        cell = np.clip((turns[chunk, None] >= F).sum(axis=1) - 1, 0, len(middle_phi) - 1)
        at = np.arange(len(chunk))
        rise = F[at, cell + 1] - F[at, cell]
        phi_i[chunk] = phi[cell] + (turns[chunk] - F[at, cell]) / rise * (phi[1] - phi[0])
    return _directions(np.cos(theta_i), phi_i, pole)
