"""Twelve unit edges in three spaces.

The octahedron with edges of length 1 in spaces of curvature -1, 0 and 1: the same number of everything, and
three volumes.
"""

import numpy as np

import isoembed
from isoembed.plot import Panel, panels
from isoembed.space.models import to_model

faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
row, volumes = [], []
for k in (-1.0, 0.0, 1.0):
    metric = isoembed.PolyhedralMetric(faces, [1.0] * 12, curvature=k)
    solid = isoembed.embed(metric, method="alexandrov")
    points = to_model(solid.space, solid.vertices, "conformal")
    row.append(
        Panel(
            points,
            solid.polygons,
            solid.mean_curvature,
            f"k = {k:g}, volume {solid.volume:.4f}",
        )
    )
    volumes.append(solid.volume)
assert np.all(np.diff(volumes) > 0) and abs(volumes[1] - 2**0.5 / 3) < 1e-12
panels(row, label="mean curvature").savefig("one_metric_three_spaces.png", dpi=150)
