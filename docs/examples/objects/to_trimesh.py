"""Moments of inertia, by trimesh.

The solid ellipsoid with semi-axes 3, 2 and 1 has the moments $m (b^2 + c^2) / 5$ about its axes. The
polyhedron in it, found from lengths, has nearly the same.
"""

import numpy as np
import trimesh  # noqa: F401, `to_trimesh` needs it

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 1000))
surface = isoembed.embed(metric)
mesh = isoembed.io.to_trimesh(surface)
found = np.sort(mesh.principal_inertia_components) / mesh.volume
assert np.allclose(found, [1.0, 2.0, 13 / 5], rtol=0.02)
mesh.export("ellipsoid.glb")
surface.plot(caption=f"moments over the mass: {np.round(found, 3)}").savefig("to_trimesh.png", dpi=220)
