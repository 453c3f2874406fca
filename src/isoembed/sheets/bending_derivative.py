"""Derivative of the bending forces with respect to edge lengths, by central differences of local fits.

The fit at a vertex depends on the edges between vertices of its chart.  Edges without a common chart are
changed together (graph coloring): some fifty assemblies of the energy in either direction, for any number of
vertices.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array

from isoembed.arrays import Floats, Indices
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.charts import Charts


def bending_force_derivative(metric: PolyhedralMetric, vertices: Floats) -> csr_array:
    """Derivatives of the energy gradient ``2 Q x`` with respect to the lengths at fixed vertices, (3 V, E).

    Parameters
    ----------
    metric : PolyhedralMetric
    vertices : ndarray, shape (V, 3)
    """
    t = metric.triangulation
    edges = _edges_of_charts(metric)
    colors = _colors(edges)
    found = csr_array((3 * t.n_vertices, t.n_edges))
    for color in range(int(colors.max()) + 1):
        mine = colors == color
        owner = np.full(t.n_vertices, -1)  # the edge changed in each chart
        rows, columns = edges[:, np.flatnonzero(mine)].nonzero()
        owner[rows] = np.flatnonzero(mine)[columns]
        # The step balances truncation and rounding errors.
        steps = np.where(mine, 1e-6 * metric.lengths, 0.0)
        (at, centers, forward), (_, _, backward) = (
            _chart_forces(BendingEnergy(metric.with_lengths(metric.lengths + sign * steps)), vertices)
            for sign in (1.0, -1.0)
        )
        e = owner[centers]
        changed = np.flatnonzero(e >= 0)
        rates = (forward - backward)[changed] / (2 * steps[e[changed], None])
        places = (3 * at[changed, None] + np.arange(3)).ravel(), np.repeat(e[changed], 3)
        found = found + csr_array(coo_array((rates.ravel(), places), shape=found.shape))
    return found


def _chart_forces(energy: BendingEnergy, vertices: Floats) -> tuple[Indices, Indices, Floats]:
    """Terms of the gradient: their vertices, the centers of their charts, and the forces (n, 3)."""
    rows = energy.rows
    at_row = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
    return rows.indices, energy.row_centers[at_row], 2 * rows.data[:, None] * (rows @ vertices)[at_row]


def _edges_of_charts(metric: PolyhedralMetric) -> csr_array:
    """Incidence, (V, E), of charts and the edges between two of their vertices."""
    charts, t = Charts.of(metric), metric.triangulation
    every = np.arange(t.n_vertices)
    places = np.concatenate([charts.centers, every]), np.concatenate([charts.neighbors, every])
    members = csr_array((np.ones(len(places[0])), places), shape=(t.n_vertices, t.n_vertices))
    a, b = t.edges.T
    return csr_array(members[:, a] * members[:, b])


def _colors(edges: csr_array) -> Indices:
    """Colors of edges, (E,), different within each chart."""
    conflicts = csr_array(edges.T @ edges)
    colors = np.full(conflicts.shape[0], -1)
    for e in range(len(colors)):
        used = set(colors[conflicts.indices[conflicts.indptr[e] : conflicts.indptr[e + 1]]].tolist())
        colors[e] = next(color for color in range(len(used) + 1) if color not in used)
    return colors
