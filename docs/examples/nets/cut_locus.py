"""The cut locus of a point on a tetrahedron.

From p, most points of the surface have one shortest path; those with two are the *cut locus*. On a
tetrahedron with equal faces the images of p in the unrolled plane are known, and the nearest to p cut out a
polygon. Folded up, its boundary (red) is the cut locus.
"""

import numpy as np
from scipy.spatial import Voronoi

import isoembed
from isoembed.plot import write_picture

u, v, p = (
    np.array([2.0, 0.0]),
    np.array([0.7, 1.6]),
    np.array([0.5, 0.25]),
)  # half turns about 0, u/2, v/2, ...
shifts = [i * u + j * v for i in range(-2, 3) for j in range(-2, 3)]
images = np.array([p, *(p + s for s in shifts if s.any()), *(s - p for s in shifts)])
turned = len(shifts)  # from here on they are images by half turns
cell = Voronoi(images)
polygon = cell.vertices[cell.regions[cell.point_region[0]]]
middles = (polygon + np.roll(polygon, -1, axis=0)) / 2
across = [
    np.abs(np.linalg.norm(images[1:] - m, axis=1) - np.linalg.norm(p - m)).argmin() + 1 for m in middles
]
sides = []
for k, image in enumerate(across):
    partner = (
        k
        if image >= turned
        else across.index(np.linalg.norm(images - (2 * p - images[image]), axis=1).argmin())
    )
    sides += [((0, k), (0, partner))] if k <= partner else []
solid = isoembed.embed(isoembed.glue([polygon], sides), method="alexandrov")
assert abs(solid.area - abs(u[0] * v[1] - u[1] * v[0]) / 2) < 1e-9 and len(solid.polygons) == 4
write_picture("cut_locus.png", solid)
