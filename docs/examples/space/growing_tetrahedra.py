"""Tetrahedra in hyperbolic space.

The larger a regular tetrahedron, the more its volume falls behind the Euclidean one, toward 1.01494, that of
the one with corners at infinity.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed

faces, sides, volumes = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.array([0.5, 1, 2, 3, 4, 6, 8]), []
for side in sides:
    metric = isoembed.PolyhedralMetric(faces, [side] * 6, curvature=-1.0)
    volumes.append(isoembed.embed(metric, method="alexandrov").volume)
ideal = 1.0149416064096536
assert np.all(np.diff(volumes) > 0) and 0.95 < volumes[-1] / ideal < 1
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(sides, volumes, "o-", label="hyperbolic")
axes.plot(sides[:3], sides[:3] ** 3 / 72**0.5, "--", label="Euclidean")
axes.axhline(ideal, color="gray", linewidth=0.8)
axes.set(xlabel="side", ylabel="volume")
axes.legend()
picture.savefig("growing_tetrahedra.png", dpi=150)
