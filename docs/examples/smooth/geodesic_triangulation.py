"""Triangles of a smooth metric.

Vertices spread evenly by the metric's own area, edges of geodesic lengths, angles between 35 and 100 degrees:
lengths for `isoembed.embed` without a surface in space.
"""

import numpy as np

import isoembed
from isoembed.plot import write_picture
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import triangulate_metric

mesh = triangulate_metric(KerrNewmanHorizon(spin=0.8), 300)
least, largest = np.degrees(mesh.angles)
assert least > 35 and largest < 100
surface = isoembed.embed(mesh.metric)
write_picture("geodesic_triangulation.png", surface, color="Gaussian curvature")
