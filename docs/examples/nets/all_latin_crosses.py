"""Five solids from one cross.

There are 17 ways to glue the sides of the Latin cross in pairs so that nothing is left open and no corner has
too much paper. They give five solids, one of them flat. The colors are what a corner is short of a full
angle.
"""

import isoembed
from isoembed.gluing import edge_gluings
from isoembed.metric.curvature import deficits
from isoembed.plot import Panel, panels

cross = [[0, 0], [1, 0], [1, 1], [1, 2], [2, 2], [2, 3], [1, 3]]
cross += [[1, 4], [0, 4], [0, 3], [-1, 3], [-1, 2], [0, 2], [0, 1]]
gluings = edge_gluings(cross)
solids = [isoembed.embed(isoembed.glue([cross], sides), method="alexandrov") for sides in gluings]
distinct = {round(solid.volume, 6): solid for solid in solids}
assert len(solids) == 17 and len(distinct) == 5
row = [
    Panel(solid.vertices, solid.polygons, deficits(solid.metric), f"volume {volume:.3f}")
    for volume, solid in sorted(distinct.items())
    if volume > 0
]
panels(row, label="angle that is missing").savefig("all_latin_crosses.png", dpi=150)
