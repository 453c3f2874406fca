"""A cuboctahedron by the names of its corners.

Where polygons have many neighbors, names are shorter than a list of sides: sides whose ends have the same two
names are glued.
"""

import isoembed
from isoembed.gluing import regular_polygon
from isoembed.plot import write_picture

triangles = ["abe", "acf", "bdg", "cdh", "eij", "fik", "gjl", "hkl"]
squares = ["abdc", "aeif", "bgje", "cfkh", "dglh", "ijlk"]
names = triangles + squares
net = isoembed.glue([regular_polygon(len(name)) for name in names], corners=names)
solid = isoembed.embed(net, method="alexandrov")
assert abs(solid.volume - 5 / 3 * 2**0.5) < 1e-9
write_picture("named_corners.png", solid, color="sides")
