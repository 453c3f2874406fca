"""An ellipse zipped from one side.

The same as a pita, begun at an eighth of the perimeter. The red line is the zip.
"""

import isoembed
from isoembed.gluing import Ellipse, pita
from isoembed.plot import write_picture

solid = isoembed.embed(pita(Ellipse(2, 1), at=0.125, n=64), method="alexandrov")
assert solid.converged and len(solid.surface.seams.ends) > 0
write_picture("zipped_ellipse.png", solid, color="sides")
