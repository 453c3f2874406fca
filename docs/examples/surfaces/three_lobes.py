"""A sphere with a harmonic on it.

The curvature is negative between the lobes, which is known before anything is embedded: the lengths determine
it.
"""

import isoembed
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.metric.curvature import gaussian_curvature
from isoembed.plot import write_picture

surface = HarmonicSurface(degree=3, order=2, amplitude=0.25)
metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(surface, 200))
assert gaussian_curvature(metric).min() < 0
found = isoembed.embed(metric)
assert found.residual < 1e-10
write_picture("three_lobes.png", found, color="Gaussian curvature")
