"""One D-form after the other.

Two stadiums, one shifted against the other along the boundary: flat at first, then thicker and thicker.
"""

import numpy as np

import isoembed
from isoembed.gluing import Stadium, dform
from isoembed.plot import Panel, panels

row, volumes = [], []
for offset in (0.05, 0.12, 0.2, 0.25):
    solid = isoembed.embed(dform(Stadium(2, 1), Stadium(2, 1), offset=offset, n=48), method="alexandrov")
    row.append(Panel(solid.vertices, solid.polygons, solid.mean_curvature, f"offset {offset}"))
    volumes.append(solid.volume)
assert np.all(np.diff(volumes) > 0)
panels(row, label="mean curvature").savefig("turned_stadiums.png", dpi=150)
