"""How far a surface may be off.

If all lengths have independent errors of this standard deviation, each vertex moves by so much, to first
order.
"""

import isoembed
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.plot import Quantity, write_picture

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(CassiniPeanut(), 200)))
sigma = isoembed.Sensitivity(surface).deviation(1e-6)
print("int H dA =", surface.integrated_mean_curvature, "+-", sigma.integrated_mean_curvature)
assert sigma.vertices.shape == (200,) and 0 < sigma.volume < 1e-4
shown = Quantity("deviation", "standard deviation of a vertex", sigma.vertices)
write_picture("error_bars.png", surface, color=shown)
