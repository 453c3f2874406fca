"""A proof where the curvature is negative.

No theorem says that a peanut's lengths have one surface. The certificate proves that there is one within the
radius, and that any other is farther than the isolation; moved by a millionth, the vertices are refused.
"""

import isoembed
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.plot import write_picture
from isoembed.proof.certificate import certify

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(CassiniPeanut(), 300)))
proof = isoembed.certify(surface)
print(proof.reason)
assert proof.certified and proof.isolation > 1e4 * proof.radius
moved = surface.vertices.copy()
moved[3, 2] += 1e-6 * surface.metric.mean_length
assert not certify(surface.metric, moved).certified
write_picture("certified_peanut.png", surface, color="Gaussian curvature")
