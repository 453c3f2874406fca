"""Cotangent Laplacian, and derivatives of the deficits with respect to conformal factors."""

from typing import cast

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.metric.glued import GluedMetric


def cotangent_laplacian(metric: GluedMetric, least: float = -np.inf) -> csc_array:
    """Laplacian with weights ``(cot alpha + cot beta) / 2`` from the two angles opposite to an edge.

    It is that of linear finite elements.  On the sphere and in the hyperbolic plane, the cotangents are
    replaced by the tilts of the triangles, which coincide with them in the plane.

    Parameters
    ----------
    metric : GluedMetric
    least : float
        Lower bound to which weights are clipped; on a Delaunay triangulation none is negative.

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric matrix with zero row sums.
    """
    weights = np.maximum(_weights(metric), least)
    return _assembled(metric, -weights, weights)


def deficit_laplacian(metric: GluedMetric) -> csc_array:
    """Derivative of the deficits with respect to conformal factors u, at u = 0.

    The chord c of the edge from i to j becomes ``c exp((u_i + u_j) / 2)``, see
    `isoembed.metric.conformal.equivalent`.  In the plane it is the `cotangent_laplacian`.  With curvature k,
    weights W of the latter and edges of length l, the quadratic form has the terms
    ``W ((u_i - u_j)^2 - k tn(l / 2)^2 (u_i + u_j)^2)`` (in the hyperbolic plane: Bobenko, Pinkall and
    Springborn, Discrete conformal maps and ideal hyperbolic polyhedra, Geom. Topol. 19, 2015, section 6).

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric matrix.
    """
    weights = _weights(metric)
    if metric.space.is_euclidean:
        return _assembled(metric, -weights, weights)
    lengths = metric.face_lengths.ravel()
    share = weights / metric.space.cs(lengths / 2) ** 2
    return _assembled(metric, -share, share * metric.space.cs(lengths))


def _weights(metric: GluedMetric) -> Floats:
    across = np.roll(metric.triangles.tilts, 1, axis=1).ravel()
    return (across + across[metric.twins]) / 2


def _assembled(metric: GluedMetric, beside: Floats, diagonal: Floats) -> csc_array:
    """Matrix from off-diagonal entries of half-edges, and diagonal entries at their start vertices."""
    corners = metric.faces.ravel()
    on_it = cast(Floats, np.bincount(corners, diagonal))
    return vertex_matrix(corners, metric.twins, beside, on_it)
