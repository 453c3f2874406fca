"""Lengths of placed vertices against those of the metric."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges


def worst_length(tables: HalfEdges, vertices: Floats) -> float:
    """The largest error of a length, over the mean length."""
    actual = np.linalg.norm(vertices[tables.corners] - vertices[tables.corners[tables.twins]], axis=1)
    return float(np.abs(actual - tables.lengths).max() / tables.lengths.mean())
