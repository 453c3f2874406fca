"""A horizon from points.

A list of points is all that a horizon finder has written. In the slice it is checked that they are on a
horizon, and the surface is embedded.
"""

import numpy as np

from isoembed.meshing.sphere import fibonacci_directions
from isoembed.plot import Panel, placed_figure
from isoembed.relativity import KerrSchild, StarSurface, embed_surface, read_horizon

slice_ = KerrSchild(1.0, (0.0, 0.0, 0.6))
u = fibonacci_directions(400)
np.savez("ah1.npz", points=slice_.spheroid(slice_.horizon)(u)[:, None] * u, center=np.zeros(3))
found = read_horizon("ah1.npz")
horizon = StarSurface.from_points(found.points, found.center)
assert np.abs(horizon.expansion(slice_, u)).max() < 1e-6
surface = embed_surface(horizon.data(slice_, marginal=True), vertices=300)
assert abs(surface.energies.christodoulou_mass.value - 1) < 1e-6
mesh = surface.mesh(600)
panel = Panel(mesh["vertices"], mesh["faces"], mesh["mean_curvature"])
placed_figure(panel, label="mean curvature").savefig("horizon_from_points.png", dpi=150)
