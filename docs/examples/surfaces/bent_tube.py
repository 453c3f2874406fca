"""A bent tube.

Long, thin, and curved like a saddle on its inner side: it comes back as it was, from its lengths.
"""

import numpy as np

import isoembed
from isoembed.gallery import BentTube, triangulate
from isoembed.plot import write_picture
from isoembed.surface.alignment import aligned

points, faces = triangulate(BentTube(), 240)
surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, faces))
assert np.abs(aligned(surface.vertices, points) - points).max() < 1e-6
write_picture("bent_tube.png", surface)
