"""A rounded box.

The superellipsoid of power 4, from 600 vertices' worth of lengths. Its sides are nearly flat, so the metric
says little there, and still enough.
"""

import isoembed
from isoembed.gallery import Superellipsoid, triangulate
from isoembed.plot import write_picture

points, faces = triangulate(Superellipsoid((2.0, 1.5, 1.0), 4.0), 600)
embedding = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, faces))
assert embedding.residual < 1e-10 and embedding.surface.rough_edges.sum() == 0
write_picture("superellipsoid.png", embedding)
