"""One wrong length.

A single length of 900 is off by forty percent. A surface with these lengths exists all the same; edges that
are bent against their neighborhood tell where to look.
"""

import numpy as np

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import write_picture

exact = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 302))
lengths = np.array(exact.lengths)
lengths[450] *= 1.4
embedding = isoembed.embed(exact.with_lengths(lengths))
around = np.isin(exact.edges, exact.edges[450]).any(axis=1)
print(f"{embedding.surface.rough_edges.sum()} rough edges")
assert embedding.converged and embedding.surface.rough_edges[around].any()
assert not isoembed.embed(exact).surface.rough_edges.any()
write_picture("wrong_length.png", embedding)
