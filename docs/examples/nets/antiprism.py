"""An antiprism with seven sides.

Two heptagons and fourteen triangles. All edges have length 1, and none of the angles between faces is given.
"""

import numpy as np

import isoembed
from isoembed.gluing import regular_polygon
from isoembed.plot import write_picture

n = 7
band = [[k, (k + 1) % n, n + k] for k in range(n)] + [[n + k, n + (k + 1) % n, (k + 1) % n] for k in range(n)]
names = [list(range(n)), list(range(n, 2 * n)), *band]
net = isoembed.glue([regular_polygon(len(name)) for name in names], corners=names)
solid = isoembed.embed(net, method="alexandrov")
c = np.cos(np.pi / (2 * n))
exact = n * np.sqrt(4 * c * c - 1) * np.sin(3 * np.pi / (2 * n)) / (12 * np.sin(np.pi / n) ** 2)
assert abs(solid.volume - exact) < 1e-9
write_picture("antiprism.png", solid, color="sides")
