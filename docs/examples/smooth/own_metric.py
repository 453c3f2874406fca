"""A metric of your own.

A function of theta and phi that returns three components is enough. This one is of an ellipsoid of
revolution, whose surface is found to ten digits.
"""

import numpy as np

from isoembed.plot import Panel, panels
from isoembed.smooth import AngleMetric, embed_smooth


def components(theta, phi):
    """Of the ellipsoid with axes 2, 2 and 1: q_tt, q_tp, q_pp."""
    return 4 * np.cos(theta) ** 2 + np.sin(theta) ** 2, 0.0, 4 * np.sin(theta) ** 2


surface = embed_smooth(AngleMetric(components), vertices=200)
poles = surface.points(np.array([[0, 0, 1.0], [0, 0, -1.0]]))
assert abs(np.linalg.norm(poles[0] - poles[1]) - 2) < 1e-10
mesh = surface.triangulated(600)
vertices = surface.points(mesh.directions)
panel = Panel(vertices, mesh.faces, surface.mean_curvature(mesh.directions))
panels([panel], label="mean curvature").savefig("own_metric.png", dpi=150)
