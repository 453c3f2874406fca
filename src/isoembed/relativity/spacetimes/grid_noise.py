"""White noise on a Cartesian grid: amplitude from high-order differences, and random samples."""

from math import comb

import numpy as np

from isoembed.arrays import Floats, Indices

ORDERS = (6, 8, 10)  # of differences; what is smooth makes less and less of them
PERIOD = 64  # spacings after which a sample of noise repeats: few points of a surface meet again


def noise_levels(fields: Floats, nodes: Indices) -> Floats:
    """Standard deviations (m,) of the noise in fields (m, nx, ny, nz) at nodes (n, 3) of the grid.

    The difference of order p along an axis, over the root of the binomial coefficient (2 p over p), has the
    standard deviation of white noise.  What is smooth adds to it: the least of all axes and orders counts.
    """
    levels = np.full(len(fields), np.inf)
    for axis in range(3):
        for order in ORDERS:
            size = fields.shape[1 + axis]
            if size <= order:
                continue
            at = nodes.copy()
            at[:, axis] = np.clip(at[:, axis] - order // 2, 0, size - order - 1)
            difference = np.zeros((len(fields), len(nodes)))
            for step in range(order + 1):
                i, j, k = at.T
                difference += (-1) ** step * comb(order, step) * fields[:, i, j, k]
                at[:, axis] += 1
            difference = difference[:, np.isfinite(difference).all(axis=0)]
            if difference.shape[1]:
                levels = np.minimum(levels, np.sqrt(np.mean(difference**2, axis=1) / comb(2 * order, order)))
    return np.where(np.isfinite(levels), levels, 0.0)


def sampled_noise(levels: Floats, margin: int, rng: np.random.Generator) -> Floats:
    """White noise of these levels (m,) on a periodic grid, with a margin after the period: (m, s, s, s)."""
    noise = levels[:, None, None, None] * rng.normal(size=(len(levels), *[PERIOD] * 3))
    return np.pad(noise, [(0, 0), *[(0, margin)] * 3], mode="wrap")
