"""Blue noise sampling of a surface: irregular points with a minimal distance."""

import numpy as np
from scipy.spatial import cKDTree

from isoembed.arrays import Floats, Indices, Mask
from isoembed.meshing.surface import Surface, spread_directions, vertex_density

CANDIDATES = 5  # random points per selected point


def _crowded_pairs(x: Floats, radii: Floats) -> tuple[Indices, Indices, Floats]:
    """Pairs i, j with overlapping balls, each pair once, and the weights of the overlaps."""
    near = cKDTree(x).query_ball_point(x, 2.0 * radii)
    i = np.repeat(np.arange(len(x)), [len(found) for found in near])
    j = np.concatenate([np.asarray(found, dtype=np.int64) for found in near])
    # Each pair is found from the point with the larger ball.
    once = (radii[i] > radii[j]) | ((radii[i] == radii[j]) & (i > j))
    i, j = i[once], j[once]
    gap = np.linalg.norm(x[i] - x[j], axis=1) / (radii[i] + radii[j])
    overlap = gap < 1.0
    return i[overlap], j[overlap], (1.0 - gap[overlap]) ** 8  # the nearest neighbor counts most


def blue_noise_directions(surface: Surface, n: int, seed: int) -> Floats:
    """Random directions (n, 3) of points with the `vertex_density` and a minimal distance.

    Distances are measured in space, not along the surface: where the surface is thinner than the spacing of
    the points, they are shared between its two sides.
    """
    u = spread_directions(surface, np.random.default_rng(seed).random((CANDIDATES * n, 2)))
    density = vertex_density(surface, u)
    total = 4.0 * np.pi * surface._radius**2 / float(np.mean(1.0 / density))
    return u[least_crowded(surface._points(u), density, total, n)]


def least_crowded(x: Floats, density: Floats, total: float, n: int) -> Mask:
    """Mask of n well-spaced points out of random points (m, 3) of a surface.

    Parameters
    ----------
    x : ndarray, shape (m, 3)
    density : ndarray, shape (m,)
        Prescribed number of points per area, up to a factor.
    total : float
        Integral of the density over the surface: the area over the mean of 1/density.
    n : int

    Notes
    -----
    The most crowded points are eliminated until n remain: in every round the worse half of those that are
    more crowded than all of their neighbors.

    References
    ----------
    C. Yuksel, "Sample elimination for generating Poisson disk sample sets" (2015).
    """
    # Radii of the densest packing of n discs in the plane.
    radii = np.sqrt(total / (2.0 * np.sqrt(3.0) * n * density))
    count = len(x)
    i, j, weight = _crowded_pairs(x, radii)

    stays, left = np.ones(count, dtype=bool), count
    while left > n:
        both = stays[i] & stays[j]
        i, j, weight = i[both], j[both], weight[both]
        crowding = np.bincount(i, weight, count) + np.bincount(j, weight, count)
        rank = np.empty(count, dtype=np.int64)
        rank[np.argsort(crowding, kind="stable")] = np.arange(count)
        highest = rank.copy()
        np.maximum.at(highest, i, rank[j])
        np.maximum.at(highest, j, rank[i])
        peaks = np.flatnonzero(stays & (rank == highest))
        peaks = peaks[np.argsort(-rank[peaks])][: min(left - n, (len(peaks) + 1) // 2)]
        stays[peaks] = False
        left -= len(peaks)
    return stays
