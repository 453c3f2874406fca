"""Length residuals of placed vertices."""

import numpy as np

from isoembed.alexandrov.loops import distances
from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.space import Space
from isoembed.space.models import to_model


def worst_length(tables: HalfEdges, vertices: Floats) -> float:
    """Largest error of a length, over the mean length."""
    return worst_of_conformal(tables, to_model(Space(tables.curvature), vertices, "conformal"))


def worst_of_conformal(tables: HalfEdges, vertices: Floats) -> float:
    """Largest error of the lengths, over their mean, for vertices in conformal coordinates."""
    worst = float(np.abs(conformal_lengths(tables, vertices) - tables.lengths).max())
    return worst / float(tables.lengths.mean()) if worst < np.inf else np.inf


def rounding_size(space: Space, vertices: Floats) -> float:
    """Scale of rounding errors: largest coordinate, on the sphere divided by the least height."""
    size = float(np.abs(vertices).max())
    return size if space.curvature <= 0 else size / float(space.heights(vertices).min())


def conformal_lengths(tables: HalfEdges, vertices: Floats) -> Floats:
    """Lengths of the half-edges, shape (3F,), between vertices in conformal coordinates."""
    return distances(tables.corners, tables.twins, vertices, tables.curvature)
