"""The sphere at infinity around a surface in the Poincare ball."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.plot.curved_space import BALL_RADIUS
from isoembed.plot.view import Pose, View

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILL, RIM = "#eef2f6", "#8c98a8"


def ball(pose: Pose, infinity: float) -> tuple[Floats, float] | None:
    """Center (3,) and radius, in half diameters of a surface, of a sphere about the origin.

    None if the sphere is too large to be drawn.
    """
    radius = infinity / pose.size
    return (pose.put(np.zeros(3)), radius) if radius <= BALL_RADIUS else None


def window(view: View, infinity: float) -> tuple[Floats, Floats]:
    """Lower left and upper right corner of a view, including the sphere at infinity."""
    low, high = view.extent
    if (around := ball(view.pose, infinity)) is None:
        return low, high
    center = view.camera[:2] @ around[0]
    return np.minimum(low, center - around[1]), np.maximum(high, center + around[1])


def draw_infinity(axes: Axes, view: View, infinity: float) -> None:
    """Draw the sphere at infinity, of the given radius about the origin, behind a surface."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    if (around := ball(view.pose, infinity)) is None:
        return
    center, radius = view.camera[:2] @ around[0], around[1]
    axes.add_patch(
        Circle(tuple(center), radius, facecolor=FILL, edgecolor=RIM, linewidth=0.8, zorder=-1, clip_on=False)
    )
    angle = np.linspace(0.0, 2 * np.pi, 181)
    for k in range(3):
        circle = np.zeros((len(angle), 3))
        circle[:, k - 2], circle[:, k - 1] = np.cos(angle), np.sin(angle)
        behind = circle @ view.camera[2] <= 0
        points = center + radius * circle @ view.camera[:2].T
        pieces = np.stack([points[:-1], points[1:]], axis=1)[behind[:-1] & behind[1:]]
        axes.add_collection(LineCollection(list(pieces), colors=RIM, linewidths=0.5, alpha=0.6, zorder=-1))
