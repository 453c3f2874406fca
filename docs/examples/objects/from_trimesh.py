"""A mesh of trimesh is taken apart and found again.

A capsule from its edge lengths alone.
"""

import trimesh

import isoembed

mesh = trimesh.creation.capsule(height=2.0, radius=1.0, count=[16, 16])
surface = isoembed.embed(isoembed.PolyhedralMetric.from_trimesh(mesh))
assert surface.converged and abs(surface.volume / mesh.volume - 1) < 1e-9
surface.plot().savefig("from_trimesh.png", dpi=220)
