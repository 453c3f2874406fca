"""Polygons to glue, and their areas."""

import numpy as np


def shoelace(polygon):
    x, y = np.asarray(polygon, dtype=float).T
    return abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2


def star(n, seed):
    """A star-shaped polygon with random radii, some of them small."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(n) + rng.uniform(0.3, 0.7, n)) / n
    radii = rng.uniform(0.2, 1.0, n)
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def twice_areas(points, triangles):
    (x, y), (u, v) = ((points[triangles[:, k]] - points[triangles[:, 0]]).T for k in (1, 2))
    return x * v - y * u
