"""Circumferences of horizons.

The polar circumference over the equatorial one: 1 for a hole at rest, and less the faster it spins.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import HorizonShape, KerrNewmanHorizon

spins, ratios = np.linspace(0.0, 0.99, 8), []
for spin in spins:
    shape = HorizonShape.of(KerrNewmanHorizon(spin=spin).data())
    ratios.append(shape.circumferences.polar.value / shape.circumferences.equatorial.value)
assert abs(ratios[0] - 1) < 1e-9 and np.all(np.diff(ratios) < 0)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(spins, ratios, "o-")
axes.set(xlabel="spin, a / M", ylabel="polar over equatorial circumference")
picture.savefig("circumferences.png", dpi=150)
