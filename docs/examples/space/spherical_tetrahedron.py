"""A sixteenth of the 3-sphere.

The regular tetrahedron with edges of a quarter of a great circle has right angles everywhere, and sixteen
copies of it fill the sphere.
"""

import numpy as np

import isoembed
from isoembed.plot import write_picture

faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
metric = isoembed.PolyhedralMetric(faces, [np.pi / 2] * 6, curvature=1.0)
solid = isoembed.embed(metric, method="alexandrov")
assert abs(solid.volume - 2 * np.pi**2 / 16) < 1e-9
write_picture("spherical_tetrahedron.png", solid)
