"""From triangles to the smooth surface.

The integral of the mean curvature of a polyhedron nears that of the smooth surface with the square of the
edge length. `SmoothIntegrals` corrects what is known of the difference.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.surface.smooth_integrals import SmoothIntegrals

body, counts, errors = Ellipsoid((2, 1.5, 1)), np.array([100, 200, 400, 800]), []
for count in counts:
    surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(body, count)))
    corrected = SmoothIntegrals.of(surface.surface, "chord").integrated_mean_curvature
    values = np.array([surface.integrated_mean_curvature, corrected.value])
    errors.append(abs(values / body.integrated_mean_curvature - 1))
slopes = np.polyfit(np.log(counts), np.log(errors), 1)[0]
assert -1.2 < slopes[0] < -0.8 and slopes[1] < -1.5  # one over the count is the edge length squared
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.loglog(counts, errors, "o-", label=["polyhedron", "corrected"])
axes.set(xlabel="vertices", ylabel="relative error of $\\int H\\,dA$")
axes.legend()
picture.savefig("second_order.png", dpi=150)
