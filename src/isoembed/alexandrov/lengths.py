"""Lengths of placed vertices against those of the metric."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.kernel import kernel


def worst_length(tables: HalfEdges, vertices: Floats) -> float:
    """The largest error of a length, over the mean length."""
    worst = _worst(tables.corners, tables.twins, tables.lengths, vertices)
    return float(worst / tables.lengths.mean())


@kernel
def _worst(corners: Indices, twins: Indices, lengths: Floats, x: Floats) -> float:
    worst = 0.0
    for h in range(corners.size):
        i, j = corners[h], corners[twins[h]]
        a, b, c = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        actual = np.sqrt(a * a + b * b + c * c)
        if not actual < np.inf:
            return np.inf
        worst = max(worst, abs(actual - lengths[h]))
    return worst
