"""The least curved space for a fast horizon.

A Kerr horizon is no surface of revolution in R³ beyond a = 0.866 M. The curvature that hyperbolic space must
have at least grows from there to one half over M².
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanHorizon, smarr_limit

limit = smarr_limit(mass=1.0)
spins = np.array([0.8, *np.linspace(limit, 1.0, 12)])
greatest = np.array([KerrNewmanHorizon(spin=spin).profile().greatest_curvature for spin in spins])
assert greatest[0] > 0 and np.isclose(greatest[-1], -0.5) and np.all(np.diff(greatest) < 0)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(spins, greatest, "o-")
axes.axhline(0, color="gray", linewidth=0.8)
axes.set(xlabel="spin, a / M", ylabel="greatest curvature of space, $k\\,M^2$")
picture.savefig("least_space.png", dpi=150)
