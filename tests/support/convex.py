"""Bodies whose metrics are convex, and metrics in their own unit."""

from functools import cache

import smooth_bodies
import zoo
from isoembed.gallery import Ellipsoid, KerrHorizon, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric

CONVEX = {
    "(3, 2, 1)": lambda: smooth_bodies.ellipsoid(800),
    "Kerr": cache(lambda: triangulate(KerrHorizon(), 500)),
    "irregular": cache(lambda: triangulate(Ellipsoid((2, 1.5, 1)), 600, irregular=3)),
    "icosahedron": zoo.icosahedron,
    "random hull": lambda: zoo.random_hull(60, 2),
}


def in_units(vertices, faces):
    """The vertices in units of the mean edge length, and the metric."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return vertices / metric.unit, metric.normalized
