"""Links of vertices: spherical polygons with the angles of the triangles at a vertex as sides.

A surface in R^3, or in hyperbolic or spherical space, has such a polygon at each inner vertex.  A polygon
with sides a_i, none longer than pi, exists only if for every subset S of an odd number of sides

    sum over S of (pi - a_i) + sum over the others of a_i >= pi

(Kapovich & Millson 1999).  Moving corners to their antipodes replaces the sides of an even subset by ``pi -
a_i``; in the resulting polygon no side is longer than the sum of all others.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.polyhedral import PolyhedralMetric

NO_LINK = "the angles at an inner vertex are the sides of a spherical polygon"


def link_gaps(metric: PolyhedralMetric) -> Floats:
    """Violations of the inequality beyond rounding, (V,), in radians; if positive, there is no link."""
    t, angles, corners = metric.triangulation, metric.triangles.angles.ravel(), metric.faces.ravel()
    sums = np.bincount(corners, np.minimum(angles, np.pi - angles))
    one_more = np.full(t.n_vertices, np.inf)
    np.minimum.at(one_more, corners, np.abs(np.pi - 2 * angles))
    sums += np.where(np.bincount(corners, angles > np.pi / 2) % 2 == 1, 0.0, one_more)
    return np.where(t.boundary_vertices, -np.inf, np.pi - sums - deficit_rounding(metric))


def without_link(metric: PolyhedralMetric, v: int) -> str:
    """Clause on a vertex without link: reason why no surface has its angles."""
    angles = np.sort(np.degrees(metric.triangles.angles[metric.faces == v]))
    largest, others = angles[-1], angles[:-1].sum()
    if largest > others:
        why = f"an angle is {largest:.6g} degrees, more than the others together, {others:.6g}"
    elif len(angles) == 3:
        why = f"three angles sum to {angles.sum():.6g} degrees, more than 360"
    else:
        why = "no spherical polygon has these angles as sides"
    return f"no surface has these lengths on these triangles: at vertex {v}, {why}"
