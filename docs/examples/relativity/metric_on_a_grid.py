"""A metric on a grid, with its errors.

A simulation gives components on a grid in theta and phi. The coarser the grid, the larger the error, and the
larger the one that is stated.
"""

import numpy as np
from matplotlib.figure import Figure

from isoembed.relativity import KerrNewmanSphere, SurfaceData, embed_surface
from isoembed.smooth import GridMetric

exact, sizes, true, stated = KerrNewmanSphere(r=3.0, spin=0.8), (8, 12, 16), [], []
integral = embed_surface(exact.data(), vertices=200).energies.integrated_mean_curvature.value
for n in sizes:
    data = SurfaceData(GridMetric.sampled(exact, n, 2 * n))
    found = embed_surface(data, vertices=200).energies.integrated_mean_curvature
    true.append(abs(found.value - integral))
    stated.append(found.error)
assert np.all(np.array(true) <= stated)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.semilogy(sizes, np.maximum(true, 1e-16), "o-", label="true error")
axes.semilogy(sizes, stated, "s-", label="stated")
axes.set(xlabel="angles theta", ylabel="error of $\\int H\\,dA$")
axes.legend()
picture.savefig("metric_on_a_grid.png", dpi=150)
