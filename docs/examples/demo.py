"""The paper's ellipsoid from its edge lengths alone: a surface, a picture and a report in ``demo/``."""

from pathlib import Path

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import read_metric, write_metric, write_report, write_surface
from isoembed.plot import write_picture

EXACT = 26.40485738798982204  # int H dA of the smooth ellipsoid with semi-axes 3, 2, 1

folder = Path("demo")
folder.mkdir(exist_ok=True)

# The coordinates are forgotten here: what is embedded is read back from the file of lengths.
vertices, faces = triangulate(Ellipsoid(axes=(3, 2, 1)), 3226)
write_metric(folder / "metric.npz", isoembed.PolyhedralMetric.from_mesh(vertices, faces))
metric = read_metric(folder / "metric.npz")

surface = isoembed.embed(metric)

write_surface(folder / "surface.ply", surface)
write_picture(folder / "surface.png", surface)
write_report(folder / "report.json", isoembed.report(surface))

report = isoembed.report(surface)
found = surface.integrated_mean_curvature
print(
    f"The (3, 2, 1) ellipsoid, {len(metric.lengths)} edge lengths, embedded by the method {surface.method!r}:"
)
print(f"  largest length error  {surface.residual:.1e} of the mean edge length")
print(f"  inverted vertices     {report['convexity']['inverted_vertices']}")
print(f"  int H dA              {found:.8f}, with H = (k1 + k2)/2")
print(f"  smooth ellipsoid      {EXACT:.8f} ({found / EXACT - 1:+.1e}, second order in the edge length)")
print(f"  time                  {sum(stage.seconds for stage in surface.stages):.2f} s")
for name in ("metric.npz", "surface.ply", "surface.png", "report.json"):
    print(f"wrote {folder / name}")
