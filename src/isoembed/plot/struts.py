"""Pictures of frames: struts colored by type, with a legend of their numbers and lengths."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.io.files import Writer, write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.endings import PICTURE_ENDINGS
from isoembed.plot.lines import Shapes, among_faces
from isoembed.plot.picture import INK, PAPER, WIDTH, check_drawable, figure_writer
from isoembed.plot.view import AZIMUTH, View
from isoembed.struts.table import StrutTable
from isoembed.surface.segments import Segments

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#000000", "#b8a800")
"""Colors distinguishable with color blindness (Okabe and Ito 2008), for up to eight types."""
FACES = np.array([0.82, 0.82, 0.8])
STRUT = 2.6  # points: largest width of a strut
LABEL = {"boxstyle": "round,pad=0.15", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
SHARE = 0.74  # of the width; the rest holds the legend
LISTED = 30  # types in the legend
FOOT = 0.25  # inches: margin of the picture


def strut_figure(surface: Embedding, table: StrutTable) -> Figure:
    """Draw a frame with its struts colored by type; up to 100 hubs are numbered.

    If some hubs are hidden, a second view from the opposite side is drawn below.

    Parameters
    ----------
    surface : Embedding
    table : StrutTable
        Strut table of this surface.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    check_drawable()
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D

    from isoembed.plot.windowless import WindowlessFigure

    n, t, x = len(table.struts), surface.triangulation, surface.vertices
    colors = np.array(
        [to_rgb(name) for name in COLORS[:n]]
        if n <= len(COLORS)
        else [colormaps["turbo"](share)[:3] for share in np.linspace(0.05, 0.95, n)]
    )
    beside = t.edge_flanks[t.edge_indices(table.edges)] // 3
    width = float(np.clip(24.0 / np.sqrt(len(table.edges)), 0.5, STRUT))
    lines = [
        (Segments(x[table.edges[table.types == k]], beside[table.types == k]), colors[k], width)
        for k in range(n)
    ]
    views = [View.of(x, surface.faces)]
    if set(np.unique(table.edges).tolist()) - set(_outside(surface, views[0]).tolist()):
        # Rotated about the long axis, so the azimuth changes sign.
        pose = replace(views[0].pose, axes=views[0].pose.axes * [1.0, -1.0, -1.0])
        views.append(View.of(x, surface.faces, pose, -2 * AZIMUTH))
    low, high = views[0].extent
    across = SHARE * WIDTH
    shown = n if n <= LISTED else LISTED - 1
    rows = [f"{one.name}  {one.count} x {one.length:.6g}" for one in table.struts[:shown]]
    rows += [f"and {n - shown} more types"] if shown < n else []
    legend = 0.24 * (len(rows) + 2)  # inches
    tall = max(across * (high[1] - low[1]) / (high[0] - low[0]), legend / len(views)) + 2 * FOOT
    height = tall * len(views)
    picture = WindowlessFigure(WIDTH, height, facecolor=PAPER)
    for k, view in enumerate(views):
        axes = picture.add_axes(
            (0.01, 1 - ((k + 1) * tall - FOOT) / height, SHARE, (tall - 2 * FOOT) / height)
        )
        _draw(axes, view, lines)
        if len(np.unique(table.edges)) <= 100:
            in_sight = _outside(surface, view)
            for v in in_sight[table.hub_types[in_sight] >= 0].tolist():
                right, up = view.put(x[v])
                axes.text(right, up, str(v), size=7, color=INK, ha="center", va="center", bbox=LABEL)
    picture.legend(
        [Line2D([], [], color=color, linewidth=STRUT) for color in (*colors[:shown], PAPER)][: len(rows)],
        rows,
        loc="center left",
        bbox_to_anchor=(SHARE + 0.01, 0.5),
        frameon=False,
        labelcolor=INK,
        fontsize=9 if len(rows) <= 20 else 7,
    )
    return picture


def _outside(surface: Embedding, view: View) -> Indices:
    """Vertices of faces whose outside is visible."""
    return np.unique(surface.faces[view.faces[~view.inside]])


def _draw(axes: Axes, view: View, lines: Sequence[tuple[Segments, Floats, float]]) -> None:
    """Draw the faces of a view, with lines among them."""
    shaded = view.shade(np.broadcast_to(FACES, (len(view.faces), 3)))
    faces = Shapes(list(view.polygons), shaded, shaded, np.full(len(shaded), 0.3))
    axes.add_collection(among_faces(view, faces, lines).collection())
    low, high = view.extent
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.axis("off")


def struts_picture_writer(path: str | os.PathLike[str], surface: Embedding, table: StrutTable) -> Writer:
    """Writer of a picture of a frame in the format of the path's ending; see `write_atomically`."""
    return figure_writer(path, strut_figure(surface, table))


def write_struts_picture(path: str | os.PathLike[str], surface: Embedding, table: StrutTable) -> None:
    """Write the picture of `strut_figure` as ``.png``, ``.svg`` or ``.pdf``.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib is not installed.
    """
    check_output(path, PICTURE_ENDINGS)
    write_atomically({Path(path): struts_picture_writer(path, surface, table)})
