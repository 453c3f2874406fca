"""Pictures of surfaces in fixed position, with axes, a length scale and an arrow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.plot.coloring import Quantity, face_means
from isoembed.plot.panel import Panel
from isoembed.plot.picture import INK, PAPER, check_drawable, color_bar, color_scale, draw
from isoembed.plot.view import Pose, View, camera

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (6.4, 5.2)  # inches, an even number of pixels
WINDOW = (-1.75, 1.6, -1.5, 1.5)  # in units of the largest distance from the origin
TRIAD, LENGTH = np.array([-1.4, -1.25]), 0.3  # position and size of the axes
BAR = np.array([1.55, -1.3])  # right end of the scale bar, whose length is at most half a unit
TIP = 1.3  # end of the arrow through the surface
NAME = np.array([-1.65, 1.35])  # left end of the arrow's name
ARROW = "#c8102e"
ORIGIN = np.zeros(3)


@dataclass(frozen=True)
class Scale:
    """Length and color scale shared by several pictures.

    Attributes
    ----------
    reach : float
        Largest distance of a vertex from the origin.
    bounds : (float, float)
        Limits of the color scale.
    extremes : (float, float)
        Smallest and largest value.
    """

    reach: float
    bounds: tuple[float, float]
    extremes: tuple[float, float]

    @classmethod
    def of(cls, surfaces: Sequence[Panel]) -> Scale:
        """Scale that fits all given surfaces."""
        reach = max(float(np.linalg.norm(panel.vertices, axis=1).max()) for panel in surfaces)
        values = np.concatenate([panel.values for panel in surfaces])
        return cls(
            reach, Quantity("", "", values).bounds, (float(np.nanmin(values)), float(np.nanmax(values)))
        )


def placed_figure(
    panel: Panel,
    *,
    label: str,
    caption: str = "",
    arrow: Sequence[float] | None = None,
    name: str = "",
    scale: Scale | None = None,
) -> Figure:
    """Draw a surface in its position in space, with the z-axis upward, from a fixed direction.

    Parameters
    ----------
    panel : Panel
        Surface around the origin.
    label : str
        Label of the values.
    caption : str
    arrow : sequence of three floats, optional
        Direction of an arrow through the origin.
    name : str
        Name of the arrow.
    scale : Scale, optional
        Scale; by default that of this surface.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidParameter
        The arrow is zero.
    FileError
        matplotlib is not installed.
    """
    if arrow is not None and not any(arrow):
        raise InvalidParameter("an arrow of 0, 0, 0 has no direction")
    check_drawable()
    from isoembed.plot.windowless import WindowlessFigure

    scale = scale or Scale.of([panel])
    colors = color_scale(*scale.bounds)
    view = View.of(panel.vertices, panel.faces, Pose(np.zeros(3), np.eye(3), scale.reach))
    picture = WindowlessFigure(*SIZE, facecolor=PAPER)
    axes = picture.add_axes((0.0, 0.12, 0.82, 0.88))
    draw(axes, view, face_means(panel.values, panel.faces), colors, panel.seams)
    axes.set_xlim(WINDOW[:2])
    axes.set_ylim(WINDOW[2:])
    draw_triad(axes)
    draw_length(axes, scale.reach)
    if arrow is not None:
        draw_arrow(axes, np.asarray(arrow, dtype=np.float64), panel.vertices / scale.reach)
        key = rf"$\longrightarrow$ {name}"
        axes.text(NAME[0], NAME[1], key, ha="left", va="center", fontsize=12, color=ARROW)
    bar = picture.add_axes((0.83, 0.22, 0.022, 0.68))
    color_bar(picture, bar, colors, np.array(scale.extremes))
    bar.set_ylabel(label, color=INK, labelpad=6, fontsize=11)
    picture.text(0.5, 0.06, caption, ha="center", va="center", fontsize=10, color=INK)
    return picture


def draw_triad(axes: Axes, at: Floats = TRIAD) -> None:
    """Draw the directions of x, y and z at a point."""
    for letter, direction in zip("xyz", camera()[:2].T, strict=True):
        _draw_tip(axes, at, at + LENGTH * direction, INK, 1.2)
        right, up = at + (LENGTH + 0.1) * direction
        axes.text(right, up, f"${letter}$", ha="center", va="center", fontsize=14, color=INK)


def draw_length(axes: Axes, reach: float, end: Floats = BAR) -> None:
    """Draw a scale bar with the given right end; its length is 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(0.5 * reach))  # may be the next one if the logarithm is rounded up
    length = max(m for m in (0.5, 1, 2, 5) if m * power <= 0.5 * reach) * power
    right, up = end
    left = right - length / reach
    axes.plot([left, right], [up, up], color=INK, linewidth=2.5, solid_capstyle="butt")
    middle = 0.5 * (left + right)
    axes.text(middle, up - 0.05, f"{length:g}", ha="center", va="top", fontsize=12, color=INK)


def draw_arrow(axes: Axes, along: Floats, vertices: Floats, center: Floats = ORIGIN) -> None:
    """Draw an axis through the center of a surface, hidden by the surface.

    A dot marks the end that points toward the viewer, a cross the other one.
    """
    along = along / np.linalg.norm(along)
    own, middle = vertices - center, camera()[:2] @ center
    sizes = np.linalg.norm(own, axis=1)
    radius = float(sizes.max())
    for sign, end, mark in ((1.0, TIP, "o"), (-1.0, 1.15, "X")):
        right, up, toward = sign * camera() @ along
        direction = np.array([right, up])
        begin = middle + sizes[np.argmax(sign * own @ along / sizes)] * direction
        order = 3 if toward > 0.0 else 0
        axes.plot(*begin, mark, color=ARROW, markersize=9, markeredgecolor=PAPER, zorder=order)
        if sign > 0.0:
            _draw_tip(axes, begin, middle + end * radius * direction, ARROW, 2.2, order)
        else:
            ends = np.stack([begin, middle + end * radius * direction], axis=1)
            axes.plot(*ends, color=ARROW, linewidth=2.2, zorder=order)


def _draw_tip(axes: Axes, begin: Floats, end: Floats, color: str, width: float, order: int = 3) -> None:
    """Draw an arrow."""
    style = {"arrowstyle": "-|>", "color": color, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (end[0], end[1]), (begin[0], begin[1]), arrowprops=style, zorder=order)
