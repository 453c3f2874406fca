"""The cotangent Laplacian: of linear finite elements, and the derivative of the deficits."""

from typing import cast

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.metric.glued import GluedMetric


def cotangent_laplacian(metric: GluedMetric, least: float = -np.inf) -> csc_array:
    """The Laplacian with the weights ``(cot alpha + cot beta) / 2`` of the two angles across from an edge.

    It is also the derivative of the deficits by conformal factors u, under which the edge from i to j becomes
    ``l_ij exp((u_i + u_j) / 2)``.

    Parameters
    ----------
    metric : GluedMetric
    least : float
        Weights below this are raised to it; on a Delaunay triangulation none is negative.

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric; its rows sum to zero.
    """
    across = np.roll(metric.triangles.cotangents, 1, axis=1).ravel()
    weights = np.maximum((across + across[metric.twins]) / 2, least)
    corners = metric.faces.ravel()
    return vertex_matrix(corners, metric.twins, -weights, cast(Floats, np.bincount(corners, weights)))
