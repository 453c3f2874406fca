"""A rectangle rolled up and pressed shut.

Two opposite sides of a rectangle meet, which makes a tube; each end is pressed flat, the upper one turned
against the lower. Four corners of 180 degrees remain: a tetrahedron.
"""

import numpy as np

import isoembed
from isoembed.gluing import rectangle
from isoembed.plot import write_picture

fold = 2.6  # where the upper side is folded, in corners
sides = [((0, 1), (0, 3)), ((0, 0), (0, 0)), ((0, 2, fold), (0, 2, fold)), ((0, fold, 3), (0, fold, 3))]
net = isoembed.glue([rectangle(2.0, 1.3)], sides)
solid = isoembed.embed(net, method="alexandrov")
assert np.allclose(net.deficits[net.deficits > 1e-9], np.pi) and len(solid.polygons) == 4
write_picture("rolled_rectangle.png", solid)
