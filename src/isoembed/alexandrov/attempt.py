"""Result of a failed search: the nearest polytope, with its vertices placed approximately."""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import spsolve

from isoembed.alexandrov.newton import Analyses, pinned
from isoembed.alexandrov.placement import placed
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix, Work
from isoembed.metric.polyhedral import PolyhedralMetric


def attempted(metric: PolyhedralMetric, core: Indices, nearest: Polytope | None, work: Work) -> Floats:
    """Approximate vertices for the given triangles, shape (V, 3), after a failed search.

    Parameters
    ----------
    metric : PolyhedralMetric
    core : ndarray of int
        Vertices of the polytope.
    nearest : Polytope or None
        Polytope with the smallest curvatures; without one, the vertices are spread over a sphere.
    work : Work
        Counter of factorizations.
    """
    n = metric.triangulation.n_vertices
    vertices = np.empty((n, 3))
    placed = np.zeros(n, dtype=np.bool_)
    placed[core] = True
    found = _spread(core.size) if nearest is None else _placed(nearest, work)
    if metric.curvature > 0:  # within the hemisphere covered by the coordinates
        found = found * min(1.0, 0.5 * metric.space.radius / float(np.abs(found).max()))  # radii of curvature
    vertices[core] = found
    if not placed.all():  # other vertices at the means of their neighbors
        adjacency = metric.triangulation.adjacency
        rest = (diags_array(metric.triangulation.degrees.astype(np.float64)) - adjacency).tocsr()[~placed]
        right = adjacency[~placed][:, placed] @ vertices[placed]
        vertices[~placed] = spsolve(rest[:, ~placed].tocsc(), right).reshape(-1, 3)
    return vertices


def _placed(nearest: Polytope, work: Work) -> Floats:
    try:
        return placed(pinned(nearest, Analyses.of(nearest.tables, work)))
    except SingularMatrix:
        return float(nearest.radii.mean()) * _spread(nearest.radii.size)


def _spread(n: int) -> Floats:
    """Points along a spiral on the unit sphere."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.arange(n) * np.pi * (1 + 5**0.5)
    radius = np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
