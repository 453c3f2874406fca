"""A surface in PyVista, with its curvature.

`to_pyvista` carries mean curvature and length errors to the points, for PyVista's filters: here one
integrates $H$ over the surface.
"""

import pyvista  # noqa: F401, `to_pyvista` needs it

import isoembed
from isoembed.gallery import CassiniPeanut, triangulate

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(CassiniPeanut(), 600)))
mesh = isoembed.io.to_pyvista(surface)
total = mesh.integrate_data()["mean_curvature"][0]
assert mesh.n_open_edges == 0 and abs(total / surface.integrated_mean_curvature - 1) < 0.01
mesh.save("peanut.vtp")
surface.plot(caption=f"int H dA by PyVista: {total:.4f}").savefig("to_pyvista.png", dpi=220)
