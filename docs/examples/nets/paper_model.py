"""A solid cut open.

`isoembed.unfold` finds where to cut so that the surface lies flat without overlaps; `write_sheets` adds tabs
and numbers for printing.
"""

from matplotlib.figure import Figure

import isoembed
from isoembed.gluing.classics import CLASSICS
from isoembed.papercraft import write_sheets

solid = isoembed.embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")
unfolding = isoembed.unfold(solid)
write_sheets("dodecahedron.pdf", unfolding)
again = isoembed.embed(unfolding.net, method="alexandrov")
assert len(unfolding.sheets) == 1 and abs(again.volume / solid.volume - 1) < 1e-12

picture = Figure(figsize=(6, 5))
axes = picture.subplots()
axes.fill(*unfolding.sheets[0].T, facecolor="#d8e4f0", edgecolor="black")
for start, end in unfolding.folds[0]:
    axes.plot(*zip(start, end, strict=True), "--", color="gray")
axes.set_aspect("equal")
picture.savefig("paper_model.png", dpi=150)
