"""Multidimensional scaling of edge-path distances, for initial surfaces."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric

LANDMARKS = (
    400  # vertices between which distances are exact: the others are placed by their distances to them
)


def scaled_distances(metric: PolyhedralMetric) -> Floats:
    """Positions in R^3 with distances close to those along the edges, (V, 3).

    Classical multidimensional scaling; for more vertices than LANDMARKS, landmark scaling with farthest-point
    sampling (de Silva and Tenenbaum, 2004).
    """
    from scipy.sparse.csgraph import dijkstra  # slow to import

    t, n = metric.triangulation, metric.triangulation.n_vertices
    a, b = t.edges.T
    ends = np.concatenate([a, b]), np.concatenate([b, a])
    graph = csr_array((np.tile(metric.lengths, 2), ends), shape=(n, n))
    if n <= LANDMARKS:
        chosen, distances = np.arange(n), dijkstra(graph, directed=False)
    else:
        chosen, distances = np.empty(LANDMARKS, dtype=np.int64), np.empty((LANDMARKS, n))
        nearest = np.full(n, np.inf)
        for k in range(LANDMARKS):
            chosen[k] = np.argmax(nearest)
            distances[k] = dijkstra(graph, directed=False, indices=chosen[k])
            nearest = np.minimum(nearest, distances[k])
    squares = distances**2
    own = squares[:, chosen]
    centered = own - own.mean(axis=0) - own.mean(axis=1)[:, None] + own.mean()
    values, vectors = np.linalg.eigh(-0.5 * centered)
    values, vectors = values[-3:], vectors[:, -3:]
    inverse = vectors / np.sqrt(np.maximum(values, 1e-12 * values[-1]))
    return -0.5 * (squares - own.mean(axis=0)[:, None]).T @ inverse
