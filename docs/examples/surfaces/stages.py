"""The method of the paper, step by step.

`method="paper"` makes the metric round first and pulls the surface back to the given lengths. A `Film` keeps
what an embedding went through.
"""

import numpy as np

import isoembed
from isoembed.gallery import Drum, triangulate
from isoembed.plot import Film, Panel, panels

film = Film()
metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Drum(), 200))
surface = isoembed.embed(metric, method=isoembed.Paper(Tsteps=10), progress=film)
frames = film.frames(surface)
chosen = [frames[k] for k in (0, len(frames) // 3, 2 * len(frames) // 3, -1)]
assert surface.residual < 1e-8
row = [Panel(f.vertices, surface.faces, np.linalg.norm(f.vertices, axis=1), f"t = {f.t:.2f}") for f in chosen]
panels(row, label="distance from the center").savefig("stages.png", dpi=150)
