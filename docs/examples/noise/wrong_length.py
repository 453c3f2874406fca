"""One wrong length.

A single length of 900 is off by forty percent. The failure names the place, and holds the best attempt.
"""

import numpy as np

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import write_picture

exact = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 302))
lengths = np.array(exact.lengths)
lengths[450] *= 1.4
try:
    isoembed.embed(exact.with_lengths(lengths))
    raise AssertionError("there is no such surface")
except isoembed.NotEmbedded as failure:
    print(failure)
    attempt = failure.embedding
assert attempt.residual > 1e-6 and set(exact.edges[450]) & set(
    exact.edges[np.argmax(np.abs(attempt.residuals))]
)
write_picture("wrong_length.png", attempt, color="residual")
