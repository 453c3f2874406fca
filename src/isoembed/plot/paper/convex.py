"""Convex pieces of the paper: whether one overlaps any of others."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.kernel import kernel


def near(others: Floats, points: Floats) -> Floats:
    """Those of other pieces, (n, m, 2), whose boxes meet that of points, (k, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    return others[((others.max(axis=1) >= low) & (others.min(axis=1) <= high)).all(axis=1)]


@kernel
def overlaps(piece: Floats, others: Floats) -> bool:
    """Whether a convex polygon, (k, 2), meets any of others, (n, m, 2), which may be segments, with m = 2.

    Two that are apart are so across a line along a side of one of them.
    """
    apart = True
    for other in others:
        apart = apart and (_apart(piece, piece, other) or _apart(other, piece, other))
    return not apart


@kernel
def _apart(sides: Floats, one: Floats, other: Floats) -> bool:
    """Whether a line along one of these sides is between the two."""
    for k in range(len(sides)):
        a, b = sides[k - 1], sides[k]
        x, y = b[1] - a[1], a[0] - b[0]
        low, high, other_low, other_high = np.inf, -np.inf, np.inf, -np.inf
        for p in one:
            across = x * p[0] + y * p[1]
            low, high = min(low, across), max(high, across)
        for p in other:
            across = x * p[0] + y * p[1]
            other_low, other_high = min(other_low, across), max(other_high, across)
        if high < other_low or other_high < low:
            return True
    return False
