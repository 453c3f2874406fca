"""The common horizon of two black holes.

Two holes at rest, half a mass unit apart (Brill and Lindquist). The outermost marginally trapped surface is
found from afar, and embedded.
"""

from isoembed.plot import Panel, placed_figure
from isoembed.relativity import BrillLindquist, embed_surface, find_horizon

pair = BrillLindquist((0.5, 0.5), ((0, 0, 0.25), (0, 0, -0.25)))
horizon = find_horizon(pair)
assert abs(horizon.irreducible_mass - 0.998248418) < 1e-9 and horizon.outer
mesh = embed_surface(horizon.data(), vertices=300).mesh(600)
panel = Panel(mesh["vertices"], mesh["faces"], mesh["mean_curvature"])
placed_figure(panel, label="mean curvature", caption="d = 0.5 M").savefig("find_a_horizon.png", dpi=150)
