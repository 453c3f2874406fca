"""Two surfaces with the same lengths.

A low cap of an icosahedron can be pushed in, and no length changes. Lengths alone do not say which is meant;
the embedding that is returned is the smoother one.
"""

import numpy as np

import isoembed
from isoembed.gluing.classics import CLASSICS
from isoembed.plot import Panel, panels

solid = isoembed.embed(dict(CLASSICS["platonic"].make())["20 triangles"], method="alexandrov")
top = solid.vertices[0]
around = solid.vertices[np.isclose(np.linalg.norm(solid.vertices - top, axis=1), 1.0)]
dented = solid.vertices.copy()
dented[0] = 2 * around.mean(axis=0) - top  # mirrored in the plane of its neighbors
metric = isoembed.PolyhedralMetric.from_mesh(dented, solid.faces)
assert np.allclose(metric.lengths, 1.0)
found = isoembed.embed(metric)
assert abs(found.volume - solid.volume) < 1e-9 and not found.surface.concave_edges.any()
row = [
    Panel(v, solid.faces, np.linalg.norm(v, axis=1), t)
    for v, t in ((dented, "given"), (found.vertices, "found"))
]
panels(row, label="distance from the origin").savefig("two_realizations.png", dpi=150)
