"""Schläfli's identity.

However a polyhedron bends, the sum of its lengths times the rates of its dihedral angles is zero. The picture
shows the rates for a random change of all lengths.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 200)))
lengths = surface.metric.lengths
variation = isoembed.Sensitivity(surface).variation(
    lengths * np.random.default_rng(0).normal(size=len(lengths))
)
terms = lengths * variation.dihedral_rates
assert abs(terms.sum()) < 1e-9 * np.abs(terms).sum()
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.hist(terms, bins=60)
axes.set(xlabel="length times rate of the dihedral angle", ylabel="edges")
picture.savefig("schlaefli.png", dpi=150)
