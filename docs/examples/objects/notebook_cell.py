"""What a notebook shows.

A surface at the end of a cell is a page to turn around: one frame, which needs no network. Here it is saved
to a file; the picture is the plot of the same surface.
"""

from pathlib import Path

import isoembed
from isoembed.gluing import regular_polygon

faces = ["abc", "acd", "ade", "aeb", "fcb", "fdc", "fed", "fbe"]  # corners of triangles
net = isoembed.glue([regular_polygon(3)] * 8, corners=faces)
octahedron = isoembed.embed(net, method="alexandrov")
cell = octahedron._repr_html_()  # what Jupyter asks for
Path("cell.html").write_text(cell, encoding="utf-8")
assert cell.startswith("<iframe") and "https://" not in cell and len(cell) < 100_000
octahedron.plot(color="sides").savefig("notebook_cell.png", dpi=220)
