"""Mean curvature of local fits, its integral, and their derivatives with respect to the edge lengths.

With the curvature vectors c, linear in the vertices x, and the normals n of the surface, ``H = -c . n``.  The
fits depend on the lengths, too: these derivatives are those of `chart_rates`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from isoembed.arrays import Floats, Indices
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.bending_derivative import chart_rates
from isoembed.surface.derivatives import normal_rates
from isoembed.surface.measures import face_normals, vertex_normals


def fitted_mean_curvature(energy: BendingEnergy, faces: Indices, vertices: Floats) -> Floats:
    """Mean curvature at the vertices, (V,): positive where bent inward."""
    normals = vertex_normals(faces, vertices)
    return -np.einsum("vi,vi->v", energy.curvature_vectors(vertices), normals)


def _at_vertices(faces: Indices, values: Floats) -> Floats:
    """Sums, (V, 3), of values of the triangles around each vertex."""
    sums = np.zeros((int(faces.max()) + 1, 3))
    for corner in faces.T:
        np.add.at(sums, corner, values)
    return sums


@dataclass(frozen=True, eq=False)
class FittedCurvatureRates:
    """Derivatives of the fitted mean curvature of a surface in R^3.

    Attributes
    ----------
    metric : PolyhedralMetric
    vertices : ndarray, shape (V, 3)
    energy : BendingEnergy
    by_lengths, areas_by_lengths : csr_array, shape (V, E)
        Derivatives of H, and of the areas of the vertices, at fixed vertices.
    """

    metric: PolyhedralMetric
    vertices: Floats
    energy: BendingEnergy
    by_lengths: csr_array
    areas_by_lengths: csr_array

    @classmethod
    def of(cls, metric: PolyhedralMetric, vertices: Floats) -> FittedCurvatureRates:
        """Differentiate the fits at given vertices."""
        t = metric.triangulation

        def terms(energy: BendingEnergy) -> Floats:
            return np.column_stack([fitted_mean_curvature(energy, t.faces, vertices), energy.areas])

        found = [csr_array((t.n_vertices, t.n_edges))] * 2
        for changed, edges, rates in chart_rates(metric, terms, np.arange(t.n_vertices)):
            found = [
                each + csr_array(coo_array((column, (changed, edges)), shape=each.shape))
                for each, column in zip(found, rates.T, strict=True)
            ]
        return cls(metric, vertices, BendingEnergy(metric), *found)

    def rates(self, changes: Floats, velocity: Floats) -> Floats:
        """Derivative of H, (V,), along changes of the lengths, (E,), that move the vertices, (V, 3)."""
        t, x = self.metric.triangulation, self.vertices
        normals, turning = (_at_vertices(t.faces, each) for each in normal_rates(t, x, velocity))
        size = np.linalg.norm(normals, axis=1)[:, None]
        n = normals / size
        dn = (turning - np.einsum("vi,vi->v", turning, n)[:, None] * n) / size
        bent = np.einsum("vi,vi->v", self.energy.curvature_vectors(velocity), n)
        turned = np.einsum("vi,vi->v", self.energy.curvature_vectors(x), dn)
        return np.asarray(self.by_lengths @ changes - bent - turned)

    def integral_gradients(self) -> tuple[Floats, Floats]:
        """Gradients of int H dA with respect to the lengths, (E,), and the vertices, (V, 3)."""
        faces, x, areas = self.metric.triangulation.faces, self.vertices, self.energy.areas
        normals = _at_vertices(faces, face_normals(faces, x))
        size = np.linalg.norm(normals, axis=1)[:, None]
        n, c = normals / size, self.energy.curvature_vectors(x)
        H = -np.einsum("vi,vi->v", c, n)
        by_lengths = self.by_lengths.T @ areas + self.areas_by_lengths.T @ H
        across = (-areas[:, None] / size * (c + H[:, None] * n))[faces].sum(axis=1)  # of normals of faces
        first, second = x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]
        at_second, at_third = np.cross(second, across), np.cross(across, first)
        by_vertices = np.zeros_like(x)
        for corner, each in zip(faces.T, (-at_second - at_third, at_second, at_third), strict=True):
            np.add.at(by_vertices, corner, each)
        return by_lengths, by_vertices - self.energy.curvature_map.T @ (areas[:, None] * n)
