"""A flat answer.

Two equal pentagons glued all around have one realization, the pentagon covered twice. That is found, and
said.
"""

import isoembed
from isoembed.gluing import regular_polygon
from isoembed.plot import write_picture

pentagon = regular_polygon(5)
net = isoembed.glue([pentagon, pentagon], corners=["abcde", "abcde"])
flat = isoembed.embed(net, method="alexandrov")
assert flat.volume < 1e-12 and flat.converged and len(flat.polygons) == 2
write_picture("doubly_covered.png", flat)
