"""Edge length constraints: residuals, Jacobian, and forces of edge tensions."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import edge_rows, length_residuals

EXACT = 1e-14  # mean edge lengths: residual of lengths, and of forces, at rounding


class LengthConstraints:
    """Constraints ``r_e = (|x_a - x_b|^2 - l_e^2) / (2 l_e) = 0`` for the edges of a metric.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric of flat triangles.
    """

    def __init__(self, metric: PolyhedralMetric) -> None:
        self.metric, self.triangulation, self.lengths = metric, metric.triangulation, metric.lengths

    def residuals(self, vertices: Floats) -> Floats:
        """Residuals r, shape (E,)."""
        return length_residuals(self.triangulation, vertices, self.lengths)

    def jacobian(self, vertices: Floats) -> csr_array:
        """Jacobian J = dr/dx, shape (E, 3V)."""
        rows, edges = edge_rows(self.triangulation, vertices, self.lengths), self.triangulation.edges
        count = len(edges)
        columns = (3 * edges[:, :, None] + np.arange(3)).reshape(count, 6)
        entries = np.concatenate([rows, -rows], axis=1)
        indptr = np.arange(0, 6 * count + 1, 6)
        return csr_array((entries.ravel(), columns.ravel(), indptr), shape=(count, vertices.size))

    def forces(self, vertices: Floats, tensions: Floats) -> Floats:
        """Forces ``J^T y`` of the tensions y, (E,), on each vertex, shape (V, 3)."""
        rows = edge_rows(self.triangulation, vertices, self.lengths)
        return self.triangulation.incidence @ (rows * tensions[:, None])
