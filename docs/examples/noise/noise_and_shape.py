"""From the noise of lengths to the error of a shape.

Up to some 1e-4 a surface follows the noise exactly; how far its vertices move grows in proportion, and the
estimate from the derivatives says by how much.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.surface.alignment import aligned

points, faces = triangulate(Ellipsoid((3, 2, 1)), 200)
exact = isoembed.PolyhedralMetric.from_mesh(points, faces)
noise, sizes = np.random.default_rng(1).normal(size=len(exact.lengths)), np.logspace(-7, -4, 4)
moved = []
for size in sizes:
    surface = isoembed.embed(exact.with_lengths(exact.lengths + size * noise))
    moved.append(np.sqrt(np.mean(np.sum((aligned(surface.vertices, points) - points) ** 2, axis=1))))
sigma = isoembed.Sensitivity(isoembed.embed(exact)).deviation(1.0).vertices
expected = np.sqrt(np.mean(sigma**2)) * sizes
assert np.all(np.abs(np.log(moved / expected)) < np.log(3))
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.loglog(sizes, moved, "o", label="measured")
axes.loglog(sizes, expected, "-", label="standard deviation")
axes.set(xlabel="error of the lengths", ylabel="motion of the vertices, rms")
axes.legend()
picture.savefig("noise_and_shape.png", dpi=150)
