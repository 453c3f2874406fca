"""The part of a metric that embeds.

Beyond Smarr's limit the caps of a Kerr horizon fit in no surface of revolution. The band between them does,
and is found to rounding.
"""

import numpy as np

from isoembed.plot import Panel, panels
from isoembed.relativity import KerrNewmanHorizon

row = []
for spin in (0.9, 0.95, 1.0):
    profile = KerrNewmanHorizon(spin=spin).profile()
    (band,) = profile.bands
    assert not profile.embeds and 0 < band.start < band.stop < np.pi
    vertices, faces = band.mesh(around=48)
    row.append(Panel(vertices, faces, np.hypot(*vertices[:, :2].T), f"a = {spin:g} M"))
panels(row, label="distance from the axis, in M").savefig("bands.png", dpi=150)
