"""Bending energy of isometric surfaces as a quadratic form of their vertices, by local fits.

The metric fixes the tangential part of the second derivatives, so that ``|II|^2 = |x_uu|^2 + 2 |x_uv|^2 +
|x_vv|^2`` in flat coordinates about any vertex: a quadratic form whose matrix depends only on the lengths.
Second derivatives are those of polynomials fitted to the neighbors in `charts`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, vstack

from isoembed.arrays import Floats, Indices
from isoembed.metric.curvature import face_areas
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.charts import Charts
from isoembed.surface.measures import vertex_normals


class BendingEnergy:
    """Bending energy ``1/4 int |II|^2 dA`` of surfaces with the lengths of a metric.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric of flat triangles, with or without boundary.

    Attributes
    ----------
    form : csr_array, shape (V, V)
        Matrix Q, including the stabilizer: the minimized energy is the trace of ``x^T Q x``.
    stabilizer : csr_array, shape (V, V)
        Stabilizing part of Q, small for smooth surfaces, however bent.
    areas : ndarray, shape (V,)
        A third of the area of the triangles at each vertex.
    rows : csr_array, shape (n, V)
        Matrix R with Q = R^T R.
    row_centers : ndarray of int64, shape (n,)
        Vertex of the chart for each row.
    """

    def __init__(self, metric: PolyhedralMetric) -> None:
        self.metric = metric
        charts = Charts.of(metric)
        t = metric.triangulation
        n = t.n_vertices
        thirds = np.repeat(face_areas(metric) / 3, 3)
        areas: Floats = np.bincount(t.faces.ravel(), thirds, minlength=n).astype(np.float64)
        inside = ~t.boundary_vertices
        self.areas = areas
        counts = np.bincount(charts.centers, minlength=n)
        begins = np.cumsum(counts) - counts
        cubic = inside & (counts >= 11)  # with fewer neighbors fits are quadratic
        parts = []
        for m in np.unique(counts):
            for with_cubics in (False, True):
                at = np.flatnonzero((counts == m) & (cubic == with_cubics))
                if len(at):
                    slots = begins[at][:, None] + np.arange(m)
                    rows = _fits(charts.positions[slots], areas[at], with_cubics)
                    parts.append((at, charts.neighbors[slots], *rows))
        self._order = np.concatenate([at for at, *_ in parts])
        self._second = _assembled([(at, near, second) for at, near, second, _ in parts], n)
        D = self._second
        S = _assembled([(at, near, misfits) for at, near, _, misfits in parts], n)
        self.stabilizer = csr_array(S.T @ S)
        fits = [(at, second) for at, _, second, _ in parts] + [(at, misfits) for at, _, _, misfits in parts]
        self.row_centers = np.concatenate([np.repeat(at, block.shape[1]) for at, block in fits])
        # At a boundary K is not given, and k1^2 + k2^2 could fall below 2 |K|.  Residuals of smooth surfaces
        # are of third order in the mesh size, and so is the error of the energy.
        stiff = np.where(t.boundary_vertices, np.sqrt(200.0), 1.0)[self.row_centers[D.shape[0] :]]
        self.rows = csr_array(vstack([D, diags_array(stiff) @ S], format="csr"))
        self.form = csr_array(self.rows.T @ self.rows)

    def square_integral(self, vertices: Floats) -> float:
        """Integral of ``|II|^2 = k1^2 + k2^2``."""
        return 4 * float(np.sum((self._second @ vertices) ** 2))

    @property
    def area(self) -> float:
        """Area of the surface."""
        return float(self.areas.sum())

    def bending(self, vertices: Floats) -> float:
        """Integral of H^2, where H is half the sum of the principal curvatures."""
        return float(self.areas @ (self.curvature_vectors(vertices) ** 2).sum(axis=1))

    def curvature_vectors(self, vertices: Floats) -> Floats:
        """Mean curvature vectors ``(x_uu + x_vv) / 2`` at each vertex, (V, 3): H times the normal."""
        return np.asarray(self.curvature_map @ vertices)

    def mean_curvature(self, vertices: Floats) -> Floats:
        """Mean curvature at the vertices, (V,): positive where bent inward."""
        normals = vertex_normals(self.metric.faces, vertices)
        return -np.einsum("vi,vi->v", self.curvature_vectors(vertices), normals)

    @cached_property
    def curvature_map(self) -> csr_array:
        """Linear map, (V, V), from the vertices to the mean curvature vectors."""
        n = len(self._order)
        chosen = np.repeat(self._order, 2), (3 * np.arange(n)[:, None] + [0, 2]).ravel()
        weights = np.repeat(1 / np.sqrt(self.areas[self._order]), 2)
        return csr_array(csr_array((weights, chosen), shape=(n, 3 * n)) @ self._second)

    def value(self, vertices: Floats) -> float:
        """Minimized energy, including the stabilizer."""
        return float(np.sum(vertices * (self.form @ vertices)))


def _fits(positions: Floats, areas: Floats, cubic: bool) -> tuple[Floats, Floats]:
    """Rows of second derivatives, (n, 3, m), and of fit residuals, (n, m, m), by neighbors.

    They are scaled by the square roots of their weights in the sum of squares.
    """
    # A mean of distances dominated by small ones: the minimum is not a smooth function of the lengths.
    h = ((positions**2).sum(axis=2) ** -2).mean(axis=1) ** -0.25
    u, v = np.moveaxis(positions / h[:, None, None], 2, 0)
    weights = 1 / (0.3 + u * u + v * v)
    linear, monomials = [u, v], [u * u / 2, u * v, v * v / 2]
    if cubic:
        monomials += [u**3, u * u * v, u * v * v, v**3]
    # The linear part is fitted first, so that it does not affect second derivatives if neighbors are few.
    L, M = np.stack(linear, axis=2), np.stack(monomials, axis=2)
    residual_map = _fit_residuals(L, weights)
    curved = residual_map @ M
    left = np.linalg.norm(curved, axis=(1, 2)) / np.linalg.norm(M, axis=(1, 2))
    G = _pseudoinverse(curved, weights, 1e-9 / np.maximum(left, 1e-9)) @ residual_map
    size = np.sqrt(areas) / h**2 / 2
    second = G[:, :3] * (size[:, None] * [1.0, np.sqrt(2.0), 1.0])[:, :, None]
    residual_map = residual_map @ (np.eye(positions.shape[1]) - M @ G)
    # A tenth of the fit residuals in the form controls modes without second derivatives.
    return second, residual_map * (weights * (size * np.sqrt(0.1))[:, None])[:, :, None]


def _fit_residuals(monomials: Floats, weights: Floats) -> Floats:
    """Residuals of values of the neighbors, (n, m, m), after a fit of the monomials, (n, m, k)."""
    return np.eye(weights.shape[1]) - monomials @ _pseudoinverse(monomials, weights, 1e-9)


def _pseudoinverse(monomials: Floats, weights: Floats, cutoff: Floats | float) -> Floats:
    """Coefficients of a weighted fit, (n, k, m), of minimum norm if there are too few neighbors."""
    return np.linalg.pinv(monomials * weights[:, :, None], rcond=cutoff) * weights[:, None, :]


def _assembled(parts: list[tuple[Indices, Indices, Floats]], n: int) -> csr_array:
    """Assemble the rows of all fits, which act on differences of neighbors from their center, to a matrix."""
    rows, columns, values, before = [], [], [], 0
    for at, near, block in parts:
        count, k, m = block.shape
        row = before + np.arange(count * k).reshape(count, k)
        rows += [np.repeat(row, m), row.ravel()]
        columns += [np.broadcast_to(near[:, None, :], block.shape).ravel(), np.repeat(at, k)]
        values += [block.ravel(), -block.sum(axis=2).ravel()]
        before += count * k
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_array(coo_array(entries, shape=(before, n)))
