"""A film of an embedding.

The surfaces on the way from the round metric to the given one, as frames and as a GIF. The picture shows four
of them.
"""

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.plot import Film, Panel, panels, write_animation

film = Film()
metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 60))
surface = isoembed.embed(metric, method=isoembed.Paper(Tsteps=4), progress=film)
frames = film.frames(surface)
write_animation("ellipsoid.gif", surface, frames[:3])
assert len(frames) > 4 and abs(frames[-1].t) < 1e-12
shown = [frames[k * (len(frames) - 1) // 3] for k in range(4)]
row = [Panel(f.vertices, surface.faces, f.vertices[:, 2], f"t = {f.t:.2f}") for f in shown]
panels(row, label="height").savefig("film.png", dpi=150)
