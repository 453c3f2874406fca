"""The energy of a Kerr horizon.

Kijowski's, Liu and Yau's energy falls from 2 M to 1.76569 M at Smarr's limit [Dunajski and
Tod](https://arxiv.org/abs/2107.12400), beyond which no surface of revolution in R³ has its metric.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanHorizon, smarr_limit

spins = np.linspace(0, smarr_limit(mass=1.0), 20)
energies = [KerrNewmanHorizon(spin=a).profile().integrated_mean_curvature / (4 * np.pi) for a in spins]
assert abs(energies[0] - 2) < 1e-12 and abs(energies[-1] - 1.76569) < 1e-5
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(spins, energies)
axes.set(xlabel="spin, a / M", ylabel="Kijowski-Liu-Yau energy / M")
picture.savefig("energy_against_spin.png", dpi=150)
