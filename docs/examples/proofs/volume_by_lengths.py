"""Which lengths make the volume grow?

The derivative of the enclosed volume by every edge, from one solve with the transposed matrix. Each vertex
shows the sum over its edges.
"""

import numpy as np

import isoembed
from isoembed.gallery import Drum, triangulate
from isoembed.plot import Quantity, write_picture
from isoembed.surface.derivatives import volume_gradient

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Drum(), 300)))
by_length = isoembed.Sensitivity(surface).vjp(volume_gradient(surface.triangulation, surface.vertices))
assert abs(by_length @ surface.metric.lengths - 3 * surface.volume) < 1e-8  # all lengths grow alike
shares = np.bincount(surface.metric.edges.ravel(), np.repeat(by_length, 2), len(surface.vertices))
write_picture("volume_by_lengths.png", surface, color=Quantity("share", "derivative of the volume", shares))
