"""First variation of intrinsic quantities with respect to lengths and conformal factors."""

from typing import cast

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.triangles import Triangles


def deficit_derivative(metric: PolyhedralMetric) -> csr_array:
    """Derivatives ``d epsilon_a / d l_e``, sparse of shape (V, E), in the inverse unit of length.

    In a triangle with angle i opposite to side i: ``d theta_i / d l_i = l_i / 2A``,
    ``d theta_i / d l_j = -cot(theta_k) / l_j``; on the sphere and in the hyperbolic plane with the sines of
    the sides and the amplitude instead of 2A.
    """
    shape = metric.triangles
    sines, amplitudes = shape.sines, shape.amplitudes
    by_side = np.empty((len(shape.opposite), 3, 3))
    for i in range(3):
        for j in range(3):
            if i == j:
                by_side[:, i, j] = sines[:, i] / amplitudes
            else:
                by_side[:, i, j] = -shape.cotangents[:, 3 - i - j] / sines[:, j]
    return _assembled(metric, -by_side / shape.unit)


def dual_area_derivative(metric: PolyhedralMetric) -> csr_array:
    """Derivatives ``d A*_a / d l_e`` of circumcentric dual areas, sparse, (V, E), in the unit of length.

    For flat triangles only.
    """
    shape = Triangles.of(metric.face_lengths)
    l, cot, areas = shape.opposite, shape.cotangents, shape.areas
    # p_m = l_m^2 cot_m / 8; a corner's kite is the sum of the other two p.
    part = np.empty((len(l), 3, 3))
    for m in range(3):
        for j in range(3):
            same = l[:, m] ** 2 * ((-1.0 if m == j else 1.0) - cot[:, m] * cot[:, j]) / (4 * areas)
            part[:, m, j] = ((cot[:, m] if m == j else 0.0) + same) * l[:, j] / 4
    kites = np.roll(part, 1, axis=1) + np.roll(part, -1, axis=1)
    return _assembled(metric, kites * shape.unit)


def area_derivative(metric: PolyhedralMetric) -> Floats:
    """Derivative of the area with respect to the lengths, shape (E,), in the unit of length."""
    shape = metric.triangles
    across = np.roll(metric.triangulation.face_edges, -1, axis=1)
    by_side = shape.space.chord(shape.opposite) / shape.space.cs(shape.opposite / 2) * shape.tilts / 2
    return cast(Floats, np.bincount(across.ravel(), by_side.ravel())) * shape.unit


def length_derivative(metric: PolyhedralMetric, u: Floats) -> csr_array:
    """Derivatives ``d l_e / d u_a`` of ``l_ab (e^{u_a} + e^{u_b}) / 2``, sparse of shape (E, V).

    Parameters
    ----------
    metric : PolyhedralMetric
        Reference metric rho_0 of the conformal factors u.
    u : ndarray, shape (V,)
    """
    edges = metric.edges
    values = metric.lengths[:, None] * np.exp(u)[edges] / 2
    rows = np.repeat(np.arange(len(edges)), 2)
    return csr_array((values.ravel(), (rows, edges.ravel())), shape=(len(edges), len(u)))


def _assembled(metric: PolyhedralMetric, by_side: Floats) -> csr_array:
    """Sum derivatives (F, corner, side opposite to corner) into a (V, E) matrix."""
    across = np.roll(metric.triangulation.face_edges, -1, axis=1)
    rows = np.repeat(metric.faces, 3, axis=1)
    columns = np.tile(across, (1, 3))
    shape = (metric.triangulation.n_vertices, metric.triangulation.n_edges)
    return csr_array((by_side.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
