"""Deficits that are noise.

An icosahedron in small triangles, written with six digits: vertices that should be flat have a little more or
less than a full angle. With `repair` they are made flat first, by the smallest conformal change of the
lengths.
"""

import numpy as np

import isoembed
from isoembed.gluing.classics import CLASSICS
from isoembed.plot import write_picture

solid = isoembed.embed(dict(CLASSICS["platonic"].make())["20 triangles"], method="alexandrov")
corners, middles = (
    solid.vertices[solid.faces],
    (solid.vertices[solid.faces] + np.roll(solid.vertices[solid.faces], -1, 1)) / 2,
)
(a, b, c), (ab, bc, ca) = corners.transpose(1, 0, 2), middles.transpose(1, 0, 2)
small = np.concatenate([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]], axis=1)
points, faces = np.unique(np.round(small.transpose(1, 0, 2).reshape(-1, 3), 6), axis=0, return_inverse=True)
metric = isoembed.PolyhedralMetric.from_mesh(points, faces.reshape(-1, 3))
try:
    isoembed.embed(metric, method="alexandrov")
    raise AssertionError("it is not convex")
except isoembed.InvalidMetric as refusal:
    print(refusal)
found = isoembed.embed(metric, method=isoembed.Alexandrov(repair=1e-5))
assert len(found.polygons) == 20 and len(found.flat_vertices) == 30
write_picture("repair.png", found)
