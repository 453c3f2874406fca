"""The hull of a metric in other triangles.

Triangles of an ellipsoid that are not those of its convex hull: `"aim"` keeps them, dents and all;
`"alexandrov"` finds the convex polyhedron of the same metric.
"""

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import Panel, panels, quantity
from isoembed.surface.alignment import aligned

metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 120, irregular=1))
kept = isoembed.embed(metric)
convex = isoembed.embed(metric, method=isoembed.Alexandrov(repair=0.1))
assert kept.surface.concave_edges.any() and not convex.surface.concave_edges.any()
row = [
    Panel(places, surface.faces, quantity(surface, "concave edges").values, surface.method)
    for surface, places in ((kept, kept.vertices), (convex, aligned(convex.vertices, kept.vertices)))
]
panels(row, label="concave edges").savefig("own_triangles.png", dpi=150)
