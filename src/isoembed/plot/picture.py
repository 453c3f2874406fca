"""The picture of a surface: triangles colored by mean curvature, lit from the upper left."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, Writer, check_output, ending, write_whole
from isoembed.plot.view import View
from isoembed.surface.embedding import Embedding

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURE_ENDINGS = (".png", ".svg", ".pdf")
WIDTH, DPI = 8.0, 220  # inches, dots an inch
COLORS, DARKEST = "viridis", 0.14  # ordered in lightness, so it survives color blindness and gray printing
RANGE = (1.0, 99.0)  # percentiles of the curvature between which the colors run
MARGINS = 0.9  # inches, below with the caption and above
LABEL = "mean curvature  $H = (k_1 + k_2)/2$"
INK, PAPER = "#1c2430", "white"


def figure(
    embedding: Embedding,
    *,
    values: NDArray[np.float64] | None = None,
    label: str = LABEL,
    caption: str = "",
) -> Figure:
    """Draw a surface, colored by its mean curvature H = (k1 + k2) / 2 or by other values.

    Parameters
    ----------
    embedding : Embedding
    values : ndarray, shape (V,), optional
        What the colors show at the vertices; by default the mean curvature of the triangles.
    label : str
        What the values are.
    caption : str
        By default the number of vertices, int H dA and the residual.

    Returns
    -------
    matplotlib.figure.Figure
        With a canvas of its own: no window and no global state.

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    try:
        from matplotlib import colormaps
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.cm import ScalarMappable
        from matplotlib.collections import PolyCollection
        from matplotlib.colors import ListedColormap, Normalize
        from matplotlib.figure import Figure
    except ImportError:
        raise FileError("pictures need matplotlib: pip install 'isoembed[plot]'") from None

    view = View.of(embedding)
    shown = embedding.mean_curvature if values is None else values
    low, high = _color_range(shown)
    shades = ListedColormap(colormaps[COLORS](np.linspace(DARKEST, 1.0, 256)))
    scale = ScalarMappable(Normalize(low, high), shades)
    colors = scale.to_rgba(shown[embedding.faces[view.faces]].mean(axis=1))[:, :3]
    shaded = view.shade(colors)

    flat = view.polygons.reshape(-1, 2)
    (left, bottom), (right, top) = flat.min(axis=0), flat.max(axis=0)
    across = 0.82 * WIDTH  # the rest is for the color bar
    height = max(across * (top - bottom) / (right - left), 0.3 * WIDTH)
    picture = Figure(figsize=(WIDTH, height + MARGINS), facecolor=PAPER)
    FigureCanvasAgg(picture)
    share = height / (height + MARGINS)
    axes = picture.add_axes((0.02, 0.72 * (1 - share), 0.82, share))
    width = float(np.clip(14.0 / np.sqrt(len(embedding.faces)), 0.1, 0.7))
    dark = shaded.mean(axis=1, keepdims=True) < 0.4
    lines = np.where(dark, 0.88 * shaded + 0.12, 0.8 * shaded)
    triangles = PolyCollection(
        list(view.polygons), facecolors=shaded, edgecolors=lines, linewidths=width, joinstyle="round"
    )
    triangles.set_rasterized(len(view.faces) > 20_000)
    axes.add_collection(triangles)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")
    axes.axis("off")

    bar_axes = picture.add_axes((0.885, 0.72 * (1 - share) + 0.1 * share, 0.018, 0.8 * share))
    below, above = shown.min() < low, shown.max() > high
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}.get(
        (below, above), "both"
    )
    bar = picture.colorbar(scale, cax=bar_axes, extend=extend)
    bar.set_label(label, color=INK, labelpad=8)
    bar.outline.set_visible(False)
    bar_axes.tick_params(colors=INK, length=3, width=0.6, labelsize=9)
    below = caption or _caption(embedding)
    picture.text(0.43, 0.25 * (1 - share), below, ha="center", va="center", fontsize=9, color=INK)
    return picture


def picture_writer(path: str | os.PathLike[str], embedding: Embedding, **drawing: Any) -> Writer:
    """Return what writes the picture in the format of this ending; see `write_whole` and `figure`."""
    drawn, format_ = figure(embedding, **drawing), ending(path)[1:]
    return lambda temporary: drawn.savefig(temporary, format=format_, dpi=DPI)


def write_picture(path: str | os.PathLike[str], embedding: Embedding) -> None:
    """Write the picture of a surface as ``.png``, ``.svg`` or ``.pdf``.

    Raises
    ------
    FileError
        The ending is not known, the file cannot be written, or matplotlib is not installed.
    """
    check_output(path, PICTURE_ENDINGS)
    write_whole({Path(path): picture_writer(path, embedding)})


def _color_range(values: NDArray[np.float64]) -> tuple[float, float]:
    low, high = np.percentile(values, RANGE)
    middle = (low + high) / 2
    half = max((high - low) / 2, 0.05 * abs(middle))  # a sphere's rounding is no structure
    return float(middle - half), float(middle + half)


def _caption(embedding: Embedding) -> str:
    t = embedding.triangulation
    return (
        f"{t.n_vertices:,} vertices, {t.n_faces:,} triangles     "
        rf"$\int\! H\,dA = {embedding.integrated_mean_curvature:.6g}$     "
        f"largest length error {embedding.residual:.0e} of the mean edge"
    )
