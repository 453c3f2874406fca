"""A cube from a cross of paper.

A polygon and which of its sides meet: that is all. The creases are found.
"""

import isoembed
from isoembed.plot import write_picture

cross = [[0, 0], [1, 0], [1, 1], [1, 2], [2, 2], [2, 3], [1, 3]]
cross += [[1, 4], [0, 4], [0, 3], [-1, 3], [-1, 2], [0, 2], [0, 1]]
pairs = [(0, 7), (1, 4), (2, 3), (5, 6), (8, 9), (10, 13), (11, 12)]
net = isoembed.glue([cross], [((0, i), (0, k)) for i, k in pairs])
cube = isoembed.embed(net, method="alexandrov")
assert len(cube.polygons) == 6 and abs(cube.volume - 1) < 1e-12
write_picture("latin_cross.png", cube)
