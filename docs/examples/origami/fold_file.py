"""A net for origami programs.

The dodecahedron is unfolded and written as a crease pattern in FOLD: mountains in red, the outline in black.
"""

import json

from matplotlib.figure import Figure

import isoembed
from isoembed.gluing.classics import CLASSICS
from isoembed.io.net import write_net

solid = isoembed.embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")
write_net("net.fold", isoembed.unfold(solid))
with open("net.fold", encoding="utf-8") as file:
    net = json.load(file)
assert net["edges_assignment"].count("M") == 11 and len(net["faces_vertices"]) == 12
figure = Figure(figsize=(8, 6))
axes = figure.add_axes((0, 0, 1, 1))
for (a, b), kind in zip(net["edges_vertices"], net["edges_assignment"], strict=True):
    ends = [net["vertices_coords"][v] for v in (a, b)]
    axes.plot(*zip(*ends, strict=True), color="#d03020" if kind == "M" else "black", linewidth=2)
axes.set_aspect("equal")
axes.axis("off")
figure.savefig("fold_file.png", dpi=150)
