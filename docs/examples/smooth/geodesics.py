"""Distances on a surface.

Lengths of the shortest paths on a unit sphere, from the metric alone: right to rounding for near points.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import geodesic_lengths

sphere = KerrNewmanHorizon(mass=0.5, spin=0.0)  # the unit sphere
angles = np.array([0.05, 0.1, 0.2, 0.4, 0.8])
ends = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
found = geodesic_lengths(sphere, np.tile([0.0, 0.0, 1.0], (5, 1)), ends)
assert np.allclose(found[:4], angles[:4], rtol=1e-9, atol=0)
spinning = KerrNewmanHorizon(mass=0.5, spin=0.4)
longer = geodesic_lengths(spinning, np.tile([0.0, 0.0, 1.0], (5, 1)), ends)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(angles, found, "o-", label="a = 0")
axes.plot(angles, longer, "s-", label="a = 0.8 M")
axes.set(xlabel="angle from the pole", ylabel="geodesic distance")
axes.legend()
picture.savefig("geodesics.png", dpi=150)
