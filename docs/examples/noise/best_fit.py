"""The best fit to noisy lengths.

With one percent of noise no surface with these lengths is found near the body. The least-squares surface
comes near to them, and estimates the noise.
"""

import numpy as np

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import write_picture

exact = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 250))
noise = 0.01 * np.random.default_rng(0).normal(size=len(exact.lengths))
metric = exact.with_lengths(exact.lengths * (1 + noise))
surface = isoembed.embed(metric, method=isoembed.Aim(best_fit=True))
assert surface.status == "best fit" and 0.3 < surface.noise / 0.01 < 3
write_picture("best_fit.png", surface, color="residual")
