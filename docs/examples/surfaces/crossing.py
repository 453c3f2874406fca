"""A surface that crosses itself.

Lengths cannot exclude that. `self_intersections` lists the pairs of faces that meet where they should not,
here in a body whose vertices were pushed through the other side.
"""

import numpy as np

from isoembed.gallery import Sphere, triangulate
from isoembed.plot import Panel, panels
from isoembed.surface.intersection import self_intersections

points, faces = triangulate(Sphere(), 300)
pushed = points.copy()
pushed[:, 2] -= 2.4 * np.exp(-8 * (1 - points[:, 2]))  # the north pole goes through the south pole
pairs = self_intersections(faces, pushed)
assert len(self_intersections(faces, points)) == 0 and len(pairs) > 0
touched = np.isin(np.arange(len(faces)), pairs).astype(float)
panel = Panel(pushed, faces, touched, f"{len(pairs)} pairs of faces", at="faces")
panels([panel], label="crosses another face").savefig("crossing.png", dpi=150)
