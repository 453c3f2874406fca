"""The look that all plots of the studies share: colors, line styles, axes.  Needs matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, FAINT, PAPER = "#1c2430", "#6b7480", "white"
GRID, PALE, STONE = "#d8dce2", "#eef0f3", "#c3c9d2"

# Okabe and Ito's colors, which the common forms of color blindness tell apart (jfly.uni-koeln.de/color).
BLUE, VERMILION = "#0072b2", "#d55e00"
SERIES = (BLUE, VERMILION, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
MARKERS = ("o", "s", "^", "D", "v", "P")

WIDTH = 8.0  # inches, of a figure across the page
TEXT, SMALL = 10.0, 9.0  # points

T = TypeVar("T")


def styled(series: Iterable[T]) -> Iterator[tuple[T, dict[str, Any]]]:
    """Each of up to six series with the color and the marker of its line."""
    for one, color, marker in zip(series, SERIES, MARKERS, strict=False):
        yield one, {"color": color, "marker": marker}


def blank(height: float) -> Figure:
    """An empty figure across the page, its height in inches, with a canvas of its own: no global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH, height), facecolor=PAPER, layout="constrained")


def dress(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Give axes their labels and the common style: two spines, a pale grid, small ticks."""
    axes.set_xlabel(x, color=INK, fontsize=TEXT)
    axes.set_ylabel(y, color=INK, fontsize=TEXT)
    axes.set_title(title, color=INK, fontsize=TEXT, loc="left")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set(color=INK, linewidth=0.8)
    axes.tick_params(which="both", colors=INK, labelsize=SMALL, width=0.6)
    axes.grid(visible=True, color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)


def mark_sizes(axes: Axes, sizes: Sequence[int]) -> None:
    """Label a logarithmic axis of x at these numbers of vertices only."""
    axes.set_xticks(list(sizes), [f"{n:,}" for n in sizes])
    axes.set_xticks([], minor=True)


def legend(axes: Axes, **options: Any) -> None:
    """A legend without a frame; options as of `Axes.legend`."""
    axes.legend(frameon=False, fontsize=SMALL, labelcolor=INK, **options)


def legend_below(figure: Figure, axes: Axes) -> None:
    """One legend for all axes of a figure, below them, with the lines of these axes."""
    handles, labels = axes.get_legend_handles_labels()
    style: dict[str, Any] = {"frameon": False, "fontsize": SMALL, "labelcolor": INK}
    figure.legend(handles, labels, loc="outside lower center", ncols=4, **style)


def note(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float], **style: Any) -> None:
    """Write beside a point, at an offset in points; style as of `Axes.annotate`."""
    axes.annotate(text, at, xytext=offset, textcoords="offset points", **{"color": INK, **style})


def bare(axes: Axes) -> None:
    """Turn axes into a plain area for a drawing to scale."""
    axes.set_aspect("equal")
    axes.axis("off")
