"""Nearest metric without negative deficits: a quadratic program for the lengths.

The changes d of the lengths minimize ``sum (d / s)^2``, with the standard deviations s, where the deficits
``delta + D d``, to first order, are not negative, and zero at given vertices.  With multipliers u, d is
``S D^T u``, where S has the variances, and u is the solution of a linear complementarity problem:

    u >= 0,  delta + D S D^T u >= 0,  and one of the two is zero,

but u of either sign at the given vertices.  Its solutions for the deficits about the changed lengths
converge fast, as changes are small.

The conformal changes of `isoembed.metric.repair` are far from the least: of rods with errors they may be
larger than these errors.
"""

import numpy as np
from scipy.sparse import csc_array, diags_array

from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidMetric
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.repair import complementary_factors
from isoembed.metric.variation import deficit_derivative

MAX_STEPS = 10  # more than needed for small changes: two to five


def nearest_convex(metric: PolyhedralMetric, errors: Floats, flat: Mask, most: float) -> PolyhedralMetric:
    """Metric without negative deficits whose lengths are nearest to those of a given one.

    Parameters
    ----------
    metric : PolyhedralMetric
    errors : ndarray, shape (E,)
        Standard deviations of the lengths.
    flat : ndarray of bool, shape (V,)
        Vertices whose deficits become zero.
    most : float
        Largest root mean square change, in mean edge lengths.

    Returns
    -------
    PolyhedralMetric

    Raises
    ------
    InvalidMetric
        There are none nearby: the changed lengths break a triangle, are farther, or do not converge.
    """
    found = metric
    for _ in range(MAX_STEPS):
        slack, deficits = deficit_rounding(found), found.deficits
        if (np.where(flat, np.abs(deficits), -deficits) <= slack).all():
            return found
        D = deficit_derivative(found)
        across = diags_array((errors / errors.max()) ** 2) @ D.T
        H = csc_array(D @ across)
        delta = deficits - D @ (found.lengths - metric.lengths)
        try:
            u = complementary_factors(H, delta, slack / 2, flat)
        except SingularMatrix:  # no deficit would be positive
            break
        change = across @ u
        if np.sqrt(np.mean(change**2)) > most * metric.mean_length:
            break
        found = metric.with_lengths(metric.lengths + change)
    raise InvalidMetric("the nearest lengths without negative deficits are not near")
