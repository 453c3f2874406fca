"""Embedding diagrams of throats.

Equatorial planes of black holes, through the throat to the other side: Schwarzschild, Reissner and Nordström
with Q = 0.9 M, and Kerr with a = 0.9 M. Each is the sheet of least bending with the lengths of the plane.
"""

import numpy as np

import isoembed
from isoembed.plot import Panel, panels
from isoembed.smooth import AngleMetric, triangulate_metric


def plane(spin=0.0, charge=0.0):
    """The plane of a hole with M = 1, where r = 1 + (1 - a^2 - Q^2)^(1/2) cosh(theta - 1.5)."""

    def components(theta, phi):
        r = 1 + np.sqrt(1 - spin**2 - charge**2) * np.cosh(theta - 1.5)
        return r**2, 0.0, r**2 + spin**2 + spin**2 * (2 * r - charge**2) / r**2

    return AngleMetric(components)


row = []
for name, hole in (("Schwarzschild", {}), ("Q = 0.9 M", {"charge": 0.9}), ("a = 0.9 M", {"spin": 0.9})):
    mesh = triangulate_metric(plane(**hole), 100, zone=(0.3, 2.7))
    sheet = isoembed.embed(mesh.metric, boundary="free")
    assert sheet.residual < 1e-12
    row.append(Panel(sheet.vertices, sheet.faces, np.abs(mesh.polar[0] - 1.5), name))
panels(row, label="distance from the throat in s").savefig("throats.png", dpi=150)
