"""The Brown-York energy around a black hole.

Of the spheres in a static slice of Schwarzschild: from 2 M at the horizon down to M far away, with a closed
form to compare.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanSphere, embed_surface

radii, smooth = np.array([2.2, 4, 10]), np.linspace(2.2, 12, 100)
surfaces = [embed_surface(KerrNewmanSphere(r=r).data(), vertices=100) for r in radii]
found = [surface.energies.brown_york.value for surface in surfaces]
exact, curve = (r * (1 - np.sqrt(1 - 2 / r)) for r in (radii, smooth))
assert np.abs(found - exact).max() < 1e-12
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(radii, found, "o", label="found")
axes.plot(smooth, curve, "-", label="$r\\,(1 - \\sqrt{1 - 2M/r})$")
axes.set(xlabel="r / M", ylabel="energy / M")
axes.legend()
picture.savefig("brown_york.png", dpi=150)
