"""Morton (Z-curve) order of points.

Traversing a large surface in this order makes good use of the processor's cache, however the vertices are
numbered.
"""

import numpy as np

from isoembed.arrays import Floats, Indices

MASKS = ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249))


def spatial_order(points: Floats) -> Indices:
    """Permutation, (n,), that sorts finite points, (n, 3), along Morton's curve."""
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 1023 / ((high - low).max() or 1.0)
    keys = np.zeros(len(points), dtype=np.uint32)
    for axis in range(3):  # of the bounding cube, in 1024 cells per axis
        bits = ((points[:, axis] - low[axis]) * scale).astype(np.uint32)
        for shift, mask in MASKS:  # spreads the ten bits to every third place
            bits = (bits | (bits << np.uint32(shift))) & np.uint32(mask)
        keys |= bits << np.uint32(axis)
    return np.argsort(keys, kind="stable")
