"""Still pictures of surfaces, colored by a quantity and lit from the upper left."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.io.files import FileError, Writer, ending, write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.browser.ramp import diverging
from isoembed.plot.caption import faces_counted, has_own_lengths, of_integral
from isoembed.plot.coloring import Quantity, quantity, usual
from isoembed.plot.curved_space import Drawn, space_name
from isoembed.plot.endings import PICTURE_ENDINGS
from isoembed.plot.infinity import draw_infinity, window
from isoembed.plot.lines import Shapes, among_faces
from isoembed.plot.panel import Panel
from isoembed.plot.view import View
from isoembed.surface.segments import Segments

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure


WIDTH, DPI = 8.0, 220  # inches, dots per inch
SHADES = 256
MARGINS = 0.9  # inches, below with the caption and above
SHARE = 0.82  # of the width; the rest holds the color bar
MIDDLE, LONGEST = 0.43, 0.96  # of a caption, as shares of the width
GAP = 0.04  # of a panel's width, on both sides
UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Metadata without dates, for reproducible files."""
INK, PAPER, SEAM = "#1c2430", "white", "#e8502a"
SEWN = 1.2  # width of seams


def figure(
    embedding: Embedding,
    *,
    color: str | Quantity | ArrayLike | None = None,
    caption: str = "",
    ax: Axes | None = None,
) -> Figure:
    """Draw a surface.

    Parameters
    ----------
    embedding : Embedding
    color : str, Quantity, or array_like, shape (V,), optional
        Displayed quantity or its name (see `isoembed.plot.QUANTITIES`), or one number per vertex.  By default
        the mean curvature; for polyhedra with up to 200 faces the number of sides of a face.
    caption : str
        By default the number of vertices, int H dA and the residual.  With `ax`, the title of the axes, by
        default none.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into, with a color bar beside them; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        Figure of `ax`, or a new one with its own canvas: no window and no global state.

    Raises
    ------
    FileError
        matplotlib is not installed.
    InvalidParameter
        The quantity is unknown, or its values do not match the surface.
    """
    shown = quantity(embedding, usual(embedding) if color is None else color)
    panel = Panel.of(Drawn.of(embedding), embedding.vertices, shown)
    if ax is not None:
        return _into(ax, panel, shown, caption)
    return _row([panel], shown, caption or _caption(embedding))


def _into(ax: Axes, panel: Panel, shown: Quantity, title: str) -> Figure:
    """Draw a surface into axes, with a color bar beside them; return their figure."""
    scale = color_scale(*shown.bounds, shown.scale)
    draw_panel(ax, panel, scale)
    ax.autoscale_view()
    if title:
        ax.set_title(title, color=INK, fontsize=10)
    whole = ax.figure.figure  # the Figure of a SubFigure
    bar = whole.colorbar(scale, ax=ax, shrink=0.8)
    bar.outline.set_visible(False)
    bar.set_label(shown.label, color=INK)
    return whole


def panels(
    surfaces: Sequence[Panel],
    *,
    label: str,
    bounds: tuple[float, float] | None = None,
    caption: str = "",
) -> Figure:
    """Draw surfaces side by side at the same scale and with the same colors.

    Parameters
    ----------
    surfaces : sequence of Panel
        If they share vertices, align them beforehand (`isoembed.surface.alignment.aligned`).
    label : str
        Label of the values.
    bounds : (float, float), optional
        Limits of the color scale; by default those of the first surface's values.
    caption : str

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    FileError
        matplotlib is not installed.
    """
    return _row(surfaces, Quantity("", label, surfaces[0].values), caption, bounds)


def draw_panel(axes: Axes, panel: Panel, colors: ScalarMappable) -> None:
    """Draw a surface into the caller's axes in the standard pose: its longest axis lies across.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes, set to equal aspect without a frame; call ``autoscale_view`` afterward, or set the limits.
    panel : Panel
        Panel; its title is not drawn.
    colors : matplotlib.cm.ScalarMappable
        Map from values to colors: a `color_scale`, or the caller's own.
    """
    draw_view(axes, View.of(panel.vertices, panel.faces, panel.pose), panel, colors)


def draw_view(axes: Axes, view: View, panel: Panel, colors: ScalarMappable) -> None:
    """Draw a surface in a given view; see `draw_panel`."""
    draw_infinity(axes, view, panel.infinity)
    draw(axes, view, panel.face_values, colors, panel.seams, outlines=panel.outlines, boundary=panel.boundary)


def picture_writer(path: str | os.PathLike[str], embedding: Embedding, **drawing: Any) -> Writer:
    """Writer of a picture in the format of the path's ending; see `write_atomically` and `figure`."""
    return figure_writer(path, figure(embedding, **drawing))


def figure_writer(path: str | os.PathLike[str], drawn: Figure) -> Writer:
    """Writer of a figure in the format of the path's ending; see `write_atomically`."""
    form = ending(path)[1:]

    def write(temporary: Path) -> None:
        from matplotlib import rc_context

        with rc_context({"svg.hashsalt": "isoembed"}):
            drawn.savefig(temporary, format=form, dpi=DPI, metadata=UNDATED.get(form))

    return write


def write_picture(
    path: str | os.PathLike[str], embedding: Embedding, *, color: str | Quantity | ArrayLike | None = None
) -> None:
    """Write a picture of a surface as ``.png``, or in vector format as ``.svg`` or ``.pdf``.

    The color is as in `figure`.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib is not installed.
    InvalidParameter
        The quantity is unknown.
    """
    check_output(path, PICTURE_ENDINGS)
    write_atomically({Path(path): picture_writer(path, embedding, color=color)})


def check_drawable() -> None:
    """Raise an error if matplotlib is not installed.

    Raises
    ------
    FileError
    """
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise FileError("pictures need matplotlib: pip install matplotlib") from None


def _row(
    surfaces: Sequence[Panel],
    shown: Quantity,
    caption: str,
    bounds: tuple[float, float] | None = None,
) -> Figure:
    """Surfaces side by side, a color bar, titles above and a caption below."""
    check_drawable()
    from matplotlib.ticker import MaxNLocator

    from isoembed.plot.windowless import WindowlessFigure

    low, high = shown.bounds if bounds is None else bounds
    scale = color_scale(low, high, shown.scale)
    views = [View.of(panel.vertices, panel.faces, panel.pose) for panel in surfaces]
    windows = np.array([window(view, panel.infinity) for panel, view in zip(surfaces, views, strict=True)])
    (left, bottom), (right, top) = windows[:, 0].min(axis=0), windows[:, 1].max(axis=0)
    if len(surfaces) > 1:
        left, right = left - GAP * (right - left), right + GAP * (right - left)
    across = SHARE * WIDTH / len(surfaces)
    above = 0.35 if any(panel.title for panel in surfaces) else 0.0  # inches, for titles
    height = max(across * (top - bottom) / (right - left), 0.3 * WIDTH / len(surfaces))
    total = height + MARGINS + above
    picture = WindowlessFigure(WIDTH, total, facecolor=PAPER)
    foot, share = 0.72 * MARGINS / total, height / total
    for k, (panel, view) in enumerate(zip(surfaces, views, strict=True)):
        axes = picture.add_axes((0.02 + k * across / WIDTH, foot, across / WIDTH, share))
        draw_view(axes, view, panel, scale)
        axes.set_xlim(left, right)
        axes.set_ylim(bottom, top)
        if panel.title:
            axes.set_title(panel.title, color=INK, fontsize=10)

    _put_caption(picture, caption, 0.25 * MARGINS / total)
    values = np.concatenate([panel.values for panel in surfaces])
    fontsize = 10 if height > 2.5 else 8
    if shown.at == "faces" and np.ptp(values) == 0:  # a single value needs no color bar
        words = f"{shown.label}: {values[0]:g}"
        picture.text(0.9, foot + share / 2, words, rotation=90, va="center", fontsize=fontsize, color=INK)
    else:
        bar_axes = picture.add_axes((0.885, foot + 0.1 * share, 0.018, 0.8 * share))
        color_bar(picture, bar_axes, scale, values)
        bar_axes.set_ylabel(shown.label, color=INK, labelpad=8, fontsize=fontsize)
        if shown.at == "faces":
            bar_axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    return picture


def _put_caption(picture: Figure, caption: str, height: float) -> None:
    """Write a caption below the surfaces, shifted to the right or shrunk if it is too long."""
    text = picture.text(MIDDLE, height, caption, ha="center", va="center", fontsize=9, color=INK)
    width = text.get_window_extent().width / picture.bbox.width
    text.set_fontsize(9 * LONGEST / max(width, LONGEST))
    text.set_x(max(MIDDLE, (1 - LONGEST + min(width, LONGEST)) / 2))


def color_scale(low: float, high: float, scale: str = "linear") -> ScalarMappable:
    """Color map of all pictures between two values.

    Colors are monotone in lightness.  If the values have both signs, the colors diverge from nearly white at
    zero: blue for negative, orange for positive values.

    Parameters
    ----------
    low, high : float
    scale : {"linear", "log"}

    Returns
    -------
    matplotlib.cm.ScalarMappable
        Map that also accepts a color bar: ``figure.colorbar(colors, cax=axes)``.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm, Normalize

    if scale == "linear" and low < 0 < high:
        shades = ListedColormap(diverging(SHADES, low, high))
    else:
        # Monotone in lightness, for color blindness and gray printing.
        shades = ListedColormap(colormaps["viridis"](np.linspace(0.14, 1.0, SHADES)))
    return ScalarMappable((LogNorm if scale == "log" else Normalize)(low, high), shades)


def color_bar(picture: Figure, axes: Axes, scale: ScalarMappable, values: Floats) -> None:
    """Draw a color bar, with pointed ends if there are values beyond the limits."""
    low, high = scale.get_clim()
    ends = (bool((values < low).any()), bool((values > high).any()))  # false for NaN
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}.get(ends, "both")
    bar = picture.colorbar(scale, cax=axes, extend=extend)
    axes.yaxis.set_minor_formatter("")  # no labels between powers of ten
    bar.outline.set_visible(False)
    axes.tick_params(which="both", colors=INK, length=3, width=0.6, labelsize=9)


def draw(
    axes: Axes,
    view: View,
    values: Floats,
    scale: ScalarMappable,
    seams: Segments | None = None,
    opacity: float = 1.0,
    outlines: Segments | None = None,
    boundary: Segments | None = None,
) -> None:
    """Draw the visible faces.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes, set to equal aspect without a frame.
    view : View
    values : ndarray, shape (F,)
        Values of all faces; faces with NaN are gray.
    scale : matplotlib.cm.ScalarMappable
        From `color_scale`.
    seams : Segments, optional
        Lines on the faces.
    opacity : float
        Opacity of the faces; below 1 they are translucent.
    outlines : Segments, optional
        Edges to draw instead of the outlines of the faces.
    boundary : Segments, optional
        Edges along the boundary.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgb

    shown = values[view.faces]
    finite = np.isfinite(shown)[:, None]
    shaded = view.shade(np.where(finite, scale.to_rgba(np.nan_to_num(shown))[:, :3], 0.72))  # or gray
    width = float(np.clip(14.0 / np.sqrt(len(values)), 0.1, 0.7))
    rims = shaded * (0.45 + 0.35 * np.minimum(2 * shaded.mean(axis=1, keepdims=True), 1.0))  # darker
    shapes = Shapes(list(view.polygons), shaded, rims, np.full(len(shaded), width))
    if outlines is not None:
        drawn = [(outlines, rims, 0.8)]
        drawn += [] if seams is None else [(seams, np.array(to_rgb(SEAM)), SEWN)]
        shapes = among_faces(view, shapes._replace(rims=shaded), drawn)
    elif boundary is not None and len(boundary.ends):
        shapes = among_faces(view, shapes, [(boundary, np.array(to_rgb(INK)), 1.4)])
    faces = shapes.collection(opacity)
    # With more triangles, vector files contain an image.
    faces.set_rasterized(len(view.faces) > 20_000)
    axes.add_collection(faces)
    if outlines is None and seams is not None and len(seams.ends):
        in_sight = seams.ends[np.isin(seams.faces, view.faces).any(axis=1)]
        axes.add_collection(
            LineCollection(list(view.put(in_sight)), colors=SEAM, linewidths=SEWN, clip_on=False)
        )
    axes.set_aspect("equal")
    axes.axis("off")


def _caption(embedding: Embedding) -> str:
    t = embedding.triangulation
    seams = "red: glued sides of the paper" if len(embedding.surface.seams.ends) else ""
    below = "     ".join(filter(None, (seams, space_name(embedding.space))))
    above = [
        f"{t.n_vertices:,} vertices, {faces_counted(embedding)}",
        rf"$\int\! H\,dA${of_integral(embedding)} = {embedding.integrated_mean_curvature:.6g}",
    ]
    if not has_own_lengths(embedding):
        above.append(f"largest length error {embedding.residual:.1g} of the mean edge")
    return f"{'     '.join(above)}\n{below}".rstrip()
