"""A picture in one line.

`surface.plot()` is a figure of matplotlib, which a notebook shows, and which can be changed and saved.
"""

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 400))
surface = isoembed.embed(metric)
figure = surface.plot(color="Gaussian curvature", caption="400 vertices, from lengths alone")
assert figure.texts[-1].get_text().startswith("400 vertices")
figure.savefig("one_line_plot.png", dpi=220)
