"""A convex hull from its lengths.

Forty random points have a hull; of that only the triangles and the lengths of their edges are kept. The
polyhedron that comes back has the same distances between all vertices.
"""

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.distance import pdist

import isoembed
from isoembed.plot import write_picture

points = np.random.default_rng(3).normal(size=(40, 3))
points = points[ConvexHull(points).vertices]
faces = ConvexHull(points).simplices
inward = np.linalg.det(points[faces]) < 0  # the origin is inside
faces[inward] = faces[inward][:, ::-1]
solid = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, faces), method="alexandrov")
assert np.abs(pdist(solid.vertices) - pdist(points)).max() < 1e-10
write_picture("random_hull.png", solid)
