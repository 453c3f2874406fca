"""A circle joined to a square.

The disk is made as large as it must be to have the square's perimeter. Its curved edge pulls the square's
sides out of the plane.
"""

import isoembed
from isoembed.gluing import circle, dform, rectangle
from isoembed.plot import write_picture

net = dform(rectangle(1, 1), circle(), offset=0.0, n=64)
solid = isoembed.embed(net, method="alexandrov")
assert solid.converged and solid.volume > 0.05
write_picture("circle_on_square.png", solid)
