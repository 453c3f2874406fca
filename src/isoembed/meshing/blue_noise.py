"""Blue noise sampling of a surface: irregular points with a minimal distance."""

import numpy as np
from scipy.spatial import cKDTree

from isoembed.arrays import Floats, Indices
from isoembed.meshing.surface import Surface, spread_directions, vertex_density


def _crowded_pairs(x: Floats, radii: Floats) -> tuple[Indices, Indices, Floats]:
    """Pairs i, j with overlapping balls, each pair once, and the weight of the overlap."""
    near = cKDTree(x).query_ball_point(x, 2.0 * radii)
    i = np.repeat(np.arange(len(x)), [len(found) for found in near])
    j = np.concatenate([np.asarray(found, dtype=np.int64) for found in near])
    # The point with the larger ball finds every pair.
    once = (radii[i] > radii[j]) | ((radii[i] == radii[j]) & (i > j))
    i, j = i[once], j[once]
    gap = np.linalg.norm(x[i] - x[j], axis=1) / (radii[i] + radii[j])
    overlap = gap < 1.0
    return i[overlap], j[overlap], (1.0 - gap[overlap]) ** 8  # the nearest neighbor counts most


def blue_noise_directions(surface: Surface, n: int, seed: int) -> Floats:
    """Random directions (n, 3) whose points have the `vertex_density` and keep their distance.

    Notes
    -----
    Of five times as many random points the most crowded are taken out until n are left: in every round those
    that are more crowded than all of their neighbors, the worse half of them. A point crowds another in
    space, not along the surface: where the surface is thinner than the points are apart, its two sides
    share them.

    References
    ----------
    C. Yuksel, "Sample elimination for generating Poisson disk sample sets" (2015).
    """
    count = 5 * n  # random points for each that stays
    u = spread_directions(surface, np.random.default_rng(seed).random((count, 2)))
    density = vertex_density(surface, u)
    # Balls of the densest packing of n in the plane; int density dA is the area over the mean of 1/density.
    total = 4.0 * np.pi * surface._radius**2 / np.mean(1.0 / density)
    radii = np.sqrt(total / (2.0 * np.sqrt(3.0) * n * density))
    i, j, weight = _crowded_pairs(surface._points(u), radii)

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
    return u[stays]
