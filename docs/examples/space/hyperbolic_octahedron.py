"""An octahedron in hyperbolic space.

Eight triangles of side 1 cut from the hyperbolic plane and glued. It is drawn in Poincaré's ball.
"""

import isoembed
from isoembed.gluing import regular_polygon
from isoembed.plot import write_picture

names = ["abc", "acd", "ade", "aeb", "fcb", "fdc", "fed", "fbe"]
triangle = regular_polygon(3, 2.0, curvature=-1.0)
net = isoembed.glue([triangle] * 8, corners=names, curvature=-1.0)
solid = isoembed.embed(net, method="alexandrov")
assert isoembed.certify(solid).certified and solid.volume < 2**0.5 / 3 * 2**3
write_picture("hyperbolic_octahedron.png", solid)
