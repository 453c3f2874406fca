"""The Wang-Yau energy.

The least energy over all embeddings in Minkowski space. On a sphere around a spinning hole the least is at
tau = 0; along tau = s cos(theta) the energy rises like a parabola.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanSphere, embed_surface, wang_yau

data = KerrNewmanSphere(r=3.0, spin=0.8).data()
embedding = embed_surface(data, vertices=200).embedding
amplitudes = np.linspace(-1, 1, 5)
energies = [wang_yau(data, lambda u, s=s: s * u[:, 2], embedding=embedding).energy.value for s in amplitudes]
assert abs(min(energies) - 1.2196541460073282) < 1e-11 and np.argmin(energies) == 2
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(amplitudes, energies, "o-")
axes.set(xlabel="s", ylabel="Wang-Yau energy / M")
picture.savefig("wang_yau_energy.png", dpi=150)
