"""A polyhedron and its proof.

The certificate is a theorem about the floats that were returned: a convex polyhedron with these lengths
exists, and no vertex of it is farther from these than the radius.
"""

from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

counts, radii = (100, 200, 400, 800), []
for count in counts:
    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((2, 1.5, 1)), count))
    proof = isoembed.certify(isoembed.embed(metric, method="alexandrov"))
    assert proof.certified and proof.radius < 1e-10
    radii.append(proof.radius)
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.loglog(counts, radii, "o-")
axes.set(xlabel="vertices", ylabel="radius, in mean edge lengths")
picture.savefig("proof.png", dpi=150)
