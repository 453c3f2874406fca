"""The surface of the ergosphere.

A little outside of the ergosphere of a hole with a = 0.975 M, as in the paper. Its curvature is negative in
two bands around the tips.
"""

import isoembed
from isoembed.gallery import Ergosphere, triangulate
from isoembed.plot import write_picture

metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ergosphere(epsilon=0.5), 250))
surface = isoembed.embed(metric)
assert surface.residual < 1e-10
write_picture("ergosphere.png", surface, color="Gaussian curvature")
