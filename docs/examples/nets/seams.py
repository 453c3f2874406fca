"""Where the paper was glued.

Another gluing of the Latin cross gives an octahedron. The red lines are the sides of the paper, which run
across its faces; the colors are the numbers of sides of the faces.
"""

import isoembed
from isoembed.plot import write_picture

cross = [[0, 0], [1, 0], [1, 1], [1, 2], [2, 2], [2, 3], [1, 3]]
cross += [[1, 4], [0, 4], [0, 3], [-1, 3], [-1, 2], [0, 2], [0, 1]]
pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
solid = isoembed.embed(isoembed.glue([cross], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov")
assert len(solid.polygons) == 8 and abs(solid.area - 6) < 1e-12
write_picture("seams.png", solid, color="sides")
