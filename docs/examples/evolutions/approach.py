"""Two black holes come closer.

At some distance a horizon appears around both. Its irreducible mass grows as they come closer; each has less
area than both together.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import BrillLindquist, StarSurface, find_horizon

distances, masses = np.array([0.74, 0.7, 0.6, 0.5, 0.4]), []
for d in distances:
    pair = BrillLindquist((0.5, 0.5), ((0, 0, d / 2), (0, 0, -d / 2)))
    masses.append(find_horizon(pair, StarSurface.sphere((0, 0, 0), 0.6)).irreducible_mass)
assert np.all(np.diff(masses) > 0) and masses[-1] < 1
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(distances, masses, "o-")
axes.invert_xaxis()
axes.set(xlabel="distance of the holes, in M", ylabel="irreducible mass / M")
picture.savefig("approach.png", dpi=150)
