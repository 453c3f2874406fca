"""Energies beyond Smarr's limit.

With a = 0.95 M the horizon is no surface of revolution in R³. It is one in hyperbolic space of enough
curvature, and the energy has a value with the least curved of these for reference.
"""

from isoembed.plot import Panel, panels
from isoembed.relativity import KerrNewmanHorizon, embed_surface
from isoembed.space.models import to_model

surface = embed_surface(KerrNewmanHorizon(mass=1.0, spin=0.95).data(), space="hyperbolic", vertices=200)
assert abs(surface.energies.liu_yau.value - 1.93431688075) < 1e-9
mesh = surface.mesh(500)
points = to_model(surface.embedding.space, mesh["vertices"], "conformal")
panels([Panel(points, mesh["faces"], mesh["mean_curvature"])], label="mean curvature").savefig(
    "beyond_smarr.png", dpi=150
)
