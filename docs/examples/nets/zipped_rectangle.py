"""A rectangle zipped shut.

The boundary of a rectangle is glued to itself, from a point on one side on. Nobody had to find the creases
beforehand.
"""

import isoembed
from isoembed.gluing import rectangle, zipped
from isoembed.plot import write_picture

solid = isoembed.embed(zipped(rectangle(2, 1), 0.15), method="alexandrov")
assert isoembed.certify(solid).certified and abs(solid.area - 2) < 1e-12
write_picture("zipped_rectangle.png", solid)
