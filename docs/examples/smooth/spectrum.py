"""How many harmonics a surface needs.

Where metric and surface are analytic, as of a Kerr horizon, the coefficients of the surface fall
exponentially with their degree.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import embed_smooth

surface = embed_smooth(KerrNewmanHorizon(spin=0.85), vertices=200)
degrees, _ = surface.harmonics.labels
sizes = np.linalg.norm(surface.coefficients, axis=1)
largest = np.array([sizes[degrees == l].max() for l in range(surface.harmonics.degree + 1)])
odd = np.arange(1, len(largest), 2)  # a horizon is the same above and below
assert largest[odd[-1]] < 1e-8 * largest[1]
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.semilogy(odd, largest[odd], "o-")
axes.set(xlabel="degree", ylabel="largest coefficient")
picture.savefig("spectrum.png", dpi=150)
