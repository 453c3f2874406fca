"""A cube cut into small triangles.

Vertices with a full angle lie inside the faces, or on the edges; they are recognized, and the six faces
found. The given vertices keep their numbers.
"""

import numpy as np

import isoembed
from isoembed.plot import write_picture

n = 5
corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
squares = corners[[[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]]
steps = np.arange(n + 1)
grids = [
    s[0] * n + np.multiply.outer(steps, s[1] - s[0])[:, None] + np.multiply.outer(steps, s[3] - s[0])
    for s in squares
]
points, index = np.unique(np.reshape(grids, (-1, 3)), axis=0, return_inverse=True)
index = index.reshape(6, n + 1, n + 1)
a, b, c, d = (i.ravel() for i in (index[:, :-1, :-1], index[:, 1:, :-1], index[:, 1:, 1:], index[:, :-1, 1:]))
faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
cube = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(points, faces), method="alexandrov")
assert len(cube.polygons) == 6 and len(cube.flat_vertices) == len(points) - 8
write_picture("flat_vertices.png", cube)
