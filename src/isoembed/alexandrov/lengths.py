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
    worst = _worst(tables.corners, tables.twins, tables.lengths, vertices, tables.curvature)
    return float(worst / tables.lengths.mean())


def rounding_size(space: Space, vertices: Floats) -> float:
    """The largest coordinate; on the sphere over the least height, by which rounding is magnified."""
    size = float(np.abs(vertices).max())
    return size if space.curvature <= 0 else size / float(space.heights(vertices).min())


def conformal_distances(space: Space, p: Floats, q: Floats) -> Floats:
    """Distances between points in conformal coordinates, shape (n, 3)."""
    chords = np.linalg.norm(p - q, axis=1)
    if space.is_euclidean:
        return chords
    k = space.curvature / 4
    scales = (1 + k * np.einsum("ij,ij->i", p, p)) * (1 + k * np.einsum("ij,ij->i", q, q))
    return space.arc(chords / np.sqrt(scales))


@kernel
def _worst(corners: Indices, twins: Indices, lengths: Floats, x: Floats, k: float) -> float:
    worst = 0.0
    scales = np.empty(x.shape[0])
    for i in range(scales.size if k != 0 else 0):
        scales[i] = 1 + k / 4 * (x[i, 0] * x[i, 0] + x[i, 1] * x[i, 1] + x[i, 2] * x[i, 2])
    for h in range(corners.size):
        i, j = corners[h], corners[twins[h]]
        a, b, c = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        actual = np.sqrt(a * a + b * b + c * c)
        if k != 0:
            actual = arc(actual / np.sqrt(scales[i] * scales[j]), k)
        if not actual < np.inf:
            return np.inf
        worst = max(worst, abs(actual - lengths[h]))
    return worst
