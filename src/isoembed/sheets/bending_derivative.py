"""Derivative of the bending forces with respect to edge lengths, by central differences of local fits.

The fit at a vertex depends on the edges between vertices of its chart.  Edges of which no chart has two are
changed together: some fifty set-ups of the energy in either direction, however many vertices there are.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array

from isoembed.arrays import Floats, Indices
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.charts import Charts

STEP = 1e-6  # of a length: the squares of steps are as small as the rounding over them


def bending_force_derivative(metric: PolyhedralMetric, vertices: Floats) -> csr_array:
    """Derivatives by the lengths of the gradient ``2 Q x`` of the energy at fixed vertices, (3 V, E).

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
        owner = np.full(t.n_vertices, -1)  # of each chart, the edge that is changed
        rows, columns = edges[:, np.flatnonzero(mine)].nonzero()
        owner[rows] = np.flatnonzero(mine)[columns]
        steps = np.where(mine, STEP * metric.lengths, 0.0)
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
    """The gradient in parts: at which vertices, from the charts of which, and the forces (n, 3)."""
    rows = energy.rows
    at_row = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
    return rows.indices, energy.row_centers[at_row], 2 * rows.data[:, None] * (rows @ vertices)[at_row]


def _edges_of_charts(metric: PolyhedralMetric) -> csr_array:
    """Incidence, (V, E), of each chart with the edges that join two of its vertices."""
    charts, t = Charts.of(metric), metric.triangulation
    every = np.arange(t.n_vertices)
    places = np.concatenate([charts.centers, every]), np.concatenate([charts.neighbors, every])
    members = csr_array((np.ones(len(places[0])), places), shape=(t.n_vertices, t.n_vertices))
    a, b = t.edges.T
    return csr_array(members[:, a] * members[:, b])


def _colors(edges: csr_array) -> Indices:
    """Colors of edges, (E,), of which no chart has two of one color."""
    conflicts = csr_array(edges.T @ edges)
    colors = np.full(conflicts.shape[0], -1)
    for e in range(len(colors)):
        taken = set(colors[conflicts.indices[conflicts.indptr[e] : conflicts.indptr[e + 1]]].tolist())
        colors[e] = next(color for color in range(len(taken) + 1) if color not in taken)
    return colors
