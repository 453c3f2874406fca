"""The spin of a tilted hole.

A Kerr hole in Kerr-Schild coordinates whose axis is not that of the coordinates. Magnitude and axis of the
angular momentum are found from the horizon alone.
"""

import numpy as np

from isoembed.plot import Panel, placed_figure
from isoembed.relativity import KerrSchild, StarSurface, embed_surface

spin = np.array([0.0, 0.36, 0.48])
slice_ = KerrSchild(1.0, spin)
horizon = StarSurface.from_radius(slice_.spheroid(slice_.horizon))
surface = embed_surface(horizon.data(slice_, marginal=True), vertices=300)
assert abs(surface.spin.J.value - 0.6) < 1e-10
assert np.allclose(surface.spin.axis, spin / 0.6, atol=1e-8)
mesh = surface.mesh(600)
panel = Panel(mesh["vertices"], mesh["faces"], mesh["mean_curvature"])
picture = placed_figure(panel, label="mean curvature", caption="a = 0.6 M", arrow=spin, name="spin")
picture.savefig("tilted_spin.png", dpi=150)
