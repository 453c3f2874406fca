"""A needle.

A bipyramid 25 times as long as it is wide, from its lengths: no tolerance has a unit, and none is lost here.
"""

import numpy as np

import isoembed
from isoembed.plot import write_picture

n, height = 12, 25.0
turn = 2 * np.pi * np.arange(n) / n
points = np.array(
    [*np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), [0, 0, height], [0, 0, -height]]
)
upper = [[k, (k + 1) % n, n] for k in range(n)]
lower = [[(k + 1) % n, k, n + 1] for k in range(n)]
solid = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, upper + lower), method="alexandrov")
exact = n * np.sin(2 * np.pi / n) * height / 3
assert abs(solid.volume / exact - 1) < 1e-9
write_picture("needle.png", solid)
