"""A prism of PyVista, with its points merged.

PyVista's bodies have the points of sharp edges twice, so `merge` makes them one. The convex polyhedron of the
lengths has the prism's eight faces again.
"""

import warnings

import pyvista

import isoembed
from isoembed import MeshNote, PolyhedralMetric

mesh = pyvista.Cylinder(radius=1.0, height=2.0, resolution=6)
with warnings.catch_warnings():
    warnings.simplefilter("ignore", MeshNote)  # that points are merged is known
    metric = PolyhedralMetric.from_pyvista(mesh, merge=1e-5)
prism = isoembed.embed(metric, method="alexandrov")
assert sorted(prism.surface.flat_faces.sides) == [4] * 6 + [6] * 2
prism.plot(color="sides").savefig("from_pyvista.png", dpi=220)
