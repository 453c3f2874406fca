"""One length grows.

`jvp` says how all vertices follow a change of the lengths, here of a single edge. The motion is that of the
best fit: no translation, no rotation.
"""

import numpy as np

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import Quantity, write_picture

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 300)))
change = np.zeros(len(surface.metric.lengths))
change[100] = 1.0
motion = isoembed.Sensitivity(surface).jvp(change)
a, b = surface.metric.edges.T
apart = surface.vertices[a] - surface.vertices[b]
rates = np.einsum("ei,ei->e", apart, motion[a] - motion[b]) / surface.metric.lengths
assert np.allclose(rates, change, atol=1e-9)
speed = np.linalg.norm(motion, axis=1)
write_picture("one_length_grows.png", surface, color=Quantity("speed", "speed of a vertex", speed))
