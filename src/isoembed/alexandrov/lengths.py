"""Lengths of placed vertices against those of the metric."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.kernel import kernel
from isoembed.space import Space
from isoembed.space.models import to_model
from isoembed.space.trigonometry import arc


def worst_length(tables: HalfEdges, vertices: Floats) -> float:
    """The largest error of a length, over the mean length."""
    return worst_of_conformal(tables, to_model(Space(tables.curvature), vertices, "conformal"))


def worst_of_conformal(tables: HalfEdges, vertices: Floats) -> float:
    """The same of vertices in conformal coordinates."""
    worst = float(np.abs(conformal_lengths(tables, vertices) - tables.lengths).max())
    return worst / float(tables.lengths.mean()) if worst < np.inf else np.inf


def rounding_size(space: Space, vertices: Floats) -> float:
    """The largest coordinate; on the sphere over the least height, by which rounding is magnified."""
    size = float(np.abs(vertices).max())
    return size if space.curvature <= 0 else size / float(space.heights(vertices).min())


def conformal_lengths(tables: HalfEdges, vertices: Floats) -> Floats:
    """Lengths of the half-edges, shape (3F,), between vertices in conformal coordinates."""
    return _distances(tables.corners, tables.twins, vertices, tables.curvature)


@kernel
def _distances(corners: Indices, twins: Indices, x: Floats, k: float) -> Floats:
    scales = np.empty(x.shape[0])
    for i in range(scales.size if k != 0 else 0):
        scales[i] = 1 + k / 4 * (x[i, 0] * x[i, 0] + x[i, 1] * x[i, 1] + x[i, 2] * x[i, 2])
    distances = np.empty(corners.size)
    for h in range(corners.size):
        i, j = corners[h], corners[twins[h]]
        a, b, c = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        distances[h] = np.sqrt(a * a + b * b + c * c)
        if k != 0:
            distances[h] = arc(distances[h] / np.sqrt(scales[i] * scales[j]), k)
    return distances
