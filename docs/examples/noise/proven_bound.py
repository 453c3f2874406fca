"""A bound that is proven.

If no length is off by more than these errors, there is a surface with the true lengths within the bound. It
pays for the worst errors of all; the estimate of first order is what to expect.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 100)))
sizes = np.logspace(-9, -5, 5)
bounds = [isoembed.Sensitivity(surface).deviation_bound(size).vertices.max() for size in sizes]
largest = isoembed.Sensitivity(surface).deviation(1.0).vertices.max() * sizes
assert np.all(np.isfinite(bounds)) and np.all(bounds > largest)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.loglog(sizes, bounds, "s-", label="proven")
axes.loglog(sizes, largest, "o-", label="standard deviation")
axes.set(xlabel="error of the lengths", ylabel="motion of a vertex")
axes.legend()
picture.savefig("proven_bound.png", dpi=150)
