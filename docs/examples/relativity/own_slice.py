"""A sphere in a slice of your own.

A formula of the 3-metric, here isotropic Schwarzschild, and a surface in it that is not round. Derivatives
are exact: the formula is called with complex coordinates.
"""

import numpy as np

from isoembed.plot import Panel, placed_figure
from isoembed.relativity import AnalyticCallable, StarSurface, embed_surface


def gamma(x):
    """Isotropic Schwarzschild, M = 1."""
    r = np.sqrt(np.einsum("ni,ni->n", x, x))
    return ((1 + 0.5 / r) ** 4)[:, None, None] * np.eye(3)


egg = StarSurface.from_angles(lambda theta, phi: 2 + 0.5 * np.cos(theta) ** 2)
surface = embed_surface(egg.data(AnalyticCallable(gamma)), vertices=300)
print(surface.energies.brown_york)
assert 1 < surface.energies.brown_york.value < 2
mesh = surface.mesh(600)
panel = Panel(mesh["vertices"], mesh["faces"], mesh["mean_curvature"])
placed_figure(panel, label="mean curvature").savefig("own_slice.png", dpi=150)
