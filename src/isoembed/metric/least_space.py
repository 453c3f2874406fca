"""Least curved hyperbolic space in which given lengths are a convex metric."""

import numpy as np

from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Euclidean, Space


def least_convex_space(metric: PolyhedralMetric) -> Space:
    """Find the least curved space, Euclidean or hyperbolic, in which a convex polyhedron has given lengths.

    With increasing absolute curvature, the angles of a hyperbolic triangle decrease and all deficits
    increase: the least curvature with no negative deficit is unique.  There Alexandrov's theorem applies.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric; its own space is ignored.

    Returns
    -------
    Space
        Space in which the smallest deficit vanishes up to rounding; or Euclidean space, if no deficit is
        negative there up to rounding.

    Raises
    ------
    InvalidMetric
        The surface has a boundary or handles.
    """
    metric.triangulation.check_sphere()
    normalized = metric.normalized
    t, lengths = normalized.triangulation, normalized.lengths

    def smallest_deficit(size: float) -> float:
        return float(deficits(PolyhedralMetric.on(t, lengths, Space(-size))).min())

    flat = PolyhedralMetric.on(t, lengths)
    if (deficits(flat) >= -deficit_rounding(flat)).all():
        return Euclidean()
    from scipy.optimize import brentq  # slow to import, rarely needed

    low, high = 0.0, 1e-6  # first trial curvature, over squared mean edge lengths
    while smallest_deficit(high) < 0:
        low, high = high, 4.0 * high
    size = brentq(smallest_deficit, low, high, xtol=1e-300, rtol=4 * np.finfo(np.float64).eps)
    return Space(-size).scaled(metric.unit)
