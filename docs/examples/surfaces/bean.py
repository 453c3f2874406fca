"""A bean.

Where it is bent inward the curvature is negative, and no theorem says that the lengths have one surface only.
The distance to the surface that they were taken from is measured after the best rigid motion.
"""

import numpy as np

import isoembed
from isoembed.gallery import Bean, triangulate
from isoembed.plot import write_picture
from isoembed.surface.alignment import aligned

points, faces = triangulate(Bean(), 300)
surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, faces))
assert surface.residual < 1e-10
assert np.abs(aligned(surface.vertices, points) - points).max() < 1e-6
write_picture("bean.png", surface, color="Gaussian curvature")
