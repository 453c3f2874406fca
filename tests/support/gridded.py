"""Slices on Cartesian grids that are sampled from closed forms."""

import numpy as np

from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid


def sampled(geometry, n, half, center=(0.0, 0.0, 0.0), missing=None):
    """n points along each axis of a cube; NaN where the distance from the center is below `missing`."""
    line = np.linspace(-half, half, n)
    x = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.linalg.norm(x, axis=1)
    x = x + np.array(center)

    def spread(values):
        return np.moveaxis(values.reshape(n, n, n, 3, 3), (3, 4), (0, 1))

    gamma, K = geometry.metric(x), geometry.extrinsic_curvature(x)
    if missing is not None:
        gamma[distance < missing] = np.nan
        K[distance < missing] = np.nan
    origin = np.array(center) - half
    spacing = line[1] - line[0]
    return CartesianGrid(origin, spacing, spread(gamma), None if geometry.time_symmetric else spread(K))
