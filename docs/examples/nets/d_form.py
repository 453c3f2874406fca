"""A D-form of two ellipses.

Two equal ellipses of paper, one turned against the other by an eighth of the perimeter, joined all around.
"""

import isoembed
from isoembed.gluing import Ellipse, dform
from isoembed.plot import write_picture

solid = isoembed.embed(dform(Ellipse(2, 1), Ellipse(2, 1), offset=0.125, n=80), method="alexandrov")
assert solid.converged and not solid.surface.concave_edges.any()
write_picture("d_form.png", solid)
