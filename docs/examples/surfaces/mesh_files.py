"""From a mesh file to a mesh file.

Any closed mesh is a metric: its coordinates are thrown away. The surface that comes back is written as PLY
with its mean curvature at the vertices.
"""

import numpy as np

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import read_metric, read_surface, write_surface
from isoembed.plot import write_picture

points, faces = triangulate(Ellipsoid((2, 1, 1)), 300)
with open("body.obj", "w") as file:
    np.savetxt(file, points, "v %.17g %.17g %.17g")
    np.savetxt(file, faces + 1, "f %d %d %d")
surface = isoembed.embed(read_metric("body.obj"))
write_surface("found.ply", surface)
again = read_surface("found.ply")
assert np.allclose(again.vertices, surface.vertices, rtol=0, atol=1e-6)
write_picture("mesh_files.png", surface)
