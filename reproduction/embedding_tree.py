"""The embedding tree on the sphere (paper, section 2.2, figures 2 and 3), drawn and measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import Paper, PolyhedralMetric
from isoembed.aim.embedding_tree import EmbeddingTree
from isoembed.gallery import Ellipsoid
from isoembed.progress.stages import Log
from isoembed.surface.measures import edge_lengths
from reproduction import plots
from reproduction.arrays import Floats, Indices, Mask
from reproduction.bodies import meshed
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SIDE = 0.62  # of the triangles in figure 3, in radii
TILT = 0.35  # radians, of figure 3 toward the viewer


@dataclass(frozen=True)
class _Placed:
    """A uniform metric, its tree, and what the tree made of each length."""

    metric: PolyhedralMetric
    radius: float
    tree: EmbeddingTree
    used: Mask
    errors: Floats  # relative, (E,)

    @property
    def later_layers(self) -> Indices:
        """The layer of the later end of each edge, (E,)."""
        return self.tree.layers[self.metric.edges].max(axis=1)

    @property
    def growth(self) -> float:
        """Factor by which the typical error of a determined edge grows from a layer to the next."""
        free = ~self.used & (self.errors > 0)
        return float(np.exp(np.polyfit(self.later_layers[free], np.log(self.errors[free]), 1)[0]))

    @property
    def numbers(self) -> dict[str, Any]:
        """Sizes, and the errors of the used and of the determined edges."""
        determined = self.errors[~self.used]
        return {
            "vertices": len(self.tree.layers),
            "layers": int(self.tree.layers.max()),
            "determined": len(determined),
            "used": float(self.errors[self.used].max()),
            "median": float(np.median(determined)),
            "mean": float(determined.mean()),
            "worst": float(determined.max()),
        }


def study(*, shown: int, sizes: Sequence[int]) -> Section:
    """The tree, and what it does to the edges that it does not use.

    Parameters
    ----------
    shown : int
        Vertices of the sphere that is drawn.
    sizes : sequence of int
        Vertices of the ellipsoids that are measured, rising.
    """
    placed = {n: _placed(n) for n in {shown, *sizes}}
    rows = [placed[n].numbers for n in sizes]
    pictured, largest, last = placed[shown], placed[sizes[-1]], rows[-1]
    falling = {
        key: float(np.polyfit(np.log(sizes), np.log([row[key] for row in rows]), 1)[0])
        for key in ("median", "mean", "worst")
    }
    middle = pictured.tree.layers.max() // 4
    first_edge, points = _first_edge_errors(), _fold()
    unfolded = _two_solutions(points)
    return Section.of(
        "embedding-tree",
        figures={
            "embedding-tree": _tree_figure(pictured, middle),
            "two-solutions": _choice_figure(points),
            "determined-edges": _error_figure(sizes, rows, largest),
        },
        numbers={
            "first_edge": first_edge,
            "two_solutions": unfolded,
            "ellipsoid": rows,
            "exponents": falling,
            "growth_per_layer": largest.growth,
        },
        rows=rows,
        last=last,
        falling=falling,
        growth=largest.growth**10,
        shown=shown,
        middle=middle,
        unfolded=unfolded,
        first_edge=first_edge,
    )


def _placed(n: int) -> _Placed:
    """The tree of a uniformized ellipsoid, as `Paper` makes it."""
    metric = meshed(Ellipsoid(), n).metric.normalized
    with Log().stage("embedding tree") as recorder:
        uniform = Paper().uniformize(metric, recorder)
        tree = Paper().embed_on_sphere(uniform, recorder)
    triangulation = metric.triangulation
    first = np.flatnonzero(tree.pivots[:, 0] < 0)
    later = np.flatnonzero(tree.pivots[:, 0] >= 0)
    pairs = [np.column_stack([later, tree.pivots[later, k]]) for k in range(2)]
    used = np.zeros(triangulation.n_edges, dtype=bool)
    used[triangulation.edge_indices(np.vstack([first, *pairs]))] = True
    errors = np.abs(edge_lengths(metric.edges, tree.vertices) / uniform.metric.lengths - 1)
    return _Placed(uniform.metric, uniform.radius, tree, used, errors)


def _first_edge_errors() -> dict[str, float]:
    """How far Eqs. (10)-(12) are off the sphere and off the length, at r = 1."""
    l = np.linspace(0.01, np.sqrt(2), 1000)
    root = np.sqrt(np.maximum(l**2 * (2 - l**2), 0.0))
    a = np.array([0.5, 0.5, np.sqrt(0.5)])
    b = np.column_stack([(1 - l**2 + root) / 2, (1 - l**2 - root) / 2, np.full(len(l), np.sqrt(0.5))])
    return {
        "radius": float(np.abs(np.linalg.norm(b, axis=1) - 1).max()),
        "length": float(np.abs(np.linalg.norm(b - a, axis=1) / l - 1).max()),
    }


def _fold() -> dict[str, Floats]:
    """Points of the unit sphere: the triangle i a b, k unfolded, and k folded over the edge a b."""
    half = SIDE / 2
    a, b = (np.array([sign * half, 0.0, np.sqrt(1 - half**2)]) for sign in (-1.0, 1.0))
    turn = 2 * np.arcsin(half)  # of the apexes about the axis of x, near enough to an equilateral triangle
    i = np.array([0.12 * SIDE, -np.sin(turn), np.cos(turn)])
    k = np.array([-0.2 * SIDE, np.sin(0.85 * turn), np.cos(0.85 * turn)])
    i, k = (p / np.linalg.norm(p) for p in (i, k))
    normal = np.cross(a, b)
    normal /= np.linalg.norm(normal)  # of the mirror through the center, a and b
    return {"a": a, "b": b, "i": i, "k": k, "k'": k - 2 * (k @ normal) * normal}


def _two_solutions(p: Mapping[str, Floats]) -> dict[str, float]:
    def between(x: str, y: str) -> float:
        return float(np.linalg.norm(p[x] - p[y]))

    apart = max(abs(between("k", end) - between("k'", end)) for end in "ab")
    return {"far": between("i", "k"), "near": between("i", "k'"), "apart": apart}


def _tree_figure(placed: _Placed, layer: int) -> Figure:
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.patches import Circle

    tree, triangulation = placed.tree, placed.metric.triangulation
    root = tree.vertices[triangulation.faces[Paper().root]].mean(axis=0)
    toward = root / np.linalg.norm(root)
    right = np.cross([0.3, -0.2, 1.0], toward)
    right /= np.linalg.norm(right)
    points = tree.vertices / placed.radius @ np.array([right, np.cross(toward, right), toward]).T
    flat, front = points[:, :2], points[:, 2] > 0.05

    figure = plots.blank(6.2)
    axes = figure.add_subplot()
    plots.bare(axes)
    axes.add_patch(Circle((0, 0), 1, facecolor=plots.PALE, edgecolor=plots.GRID, linewidth=1.0))
    old, new = tree.layers <= layer, tree.layers == layer + 1
    solid = triangulation.faces[(old & front)[triangulation.faces].all(axis=1)]
    axes.add_collection(PolyCollection(list(flat[solid]), facecolors=plots.STONE, edgecolors="none"))
    ends, used = triangulation.edges, placed.used
    seen = front[ends].all(axis=1)
    both_old, reaching = old[ends].all(axis=1), new[ends].any(axis=1) & (old | new)[ends].all(axis=1)
    for which, label, color, width, line in (
        (both_old & used, "used, placed", plots.INK, 1.1, "solid"),
        (reaching & used, "used for the next", plots.INK, 1.4, (0, (1, 1.6))),
        ((both_old | reaching) & ~used, "determined", plots.BLUE, 3.0, "solid"),
    ):
        segments = list(flat[ends[which & seen]])
        axes.add_collection(
            LineCollection(
                segments, colors=color, linewidths=width, linestyles=line, capstyle="round", label=label
            )
        )
    axes.plot(*flat[new & front].T, "o", color=plots.INK, markersize=5, label="next vertices")
    axes.set_xlim(-1.3, 1.3)
    axes.set_ylim(-1.03, 1.03)
    plots.legend(axes, loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.07))
    return figure


def _choice_figure(points: Mapping[str, Floats]) -> Figure:
    c, s = np.cos(TILT), np.sin(TILT)
    camera = np.array([[1.0, 0.0, 0.0], [0.0, c, s]])
    at = {name: camera @ p for name, p in points.items()}

    figure = plots.blank(3.9)
    axes = figure.add_subplot()
    plots.bare(axes)
    slope = np.radians(np.linspace(-44, 44, 60))
    for angle in np.radians(np.arange(-44, 45, 11)):  # a patch of the sphere, for depth
        for x, y in ((slope, angle), (angle, slope)):
            z = 1 / np.sqrt(1 + np.tan(x) ** 2 + np.tan(y) ** 2)
            arc = np.array(np.broadcast_arrays(np.tan(x) * z, np.tan(y) * z, z))
            axes.plot(*(camera @ arc), color=plots.GRID, linewidth=0.7, zorder=0)
    corners = np.array([at[name] for name in "iab"])
    axes.fill(*corners.T, facecolor=plots.STONE, edgecolor=plots.INK, linewidth=1.2)
    for name, color in (("k", plots.BLUE), ("k'", plots.VERMILION)):
        for end in "ab":
            axes.plot(*np.array([at[end], at[name]]).T, ":", color=color, linewidth=1.8)
        axes.plot(*np.array([at["i"], at[name]]).T, "--", color=color, linewidth=1.0)
        axes.plot(*at[name], "o", color=color, markersize=7)
    for name, words, offset, color in (
        ("a", "a", (-12, 0), plots.INK),
        ("b", "b", (12, 0), plots.INK),
        ("i", "i", (0, -13), plots.INK),
        ("k", "k, unfolded", (14, 8), plots.BLUE),
        ("k'", "k, folded", (-40, -12), plots.VERMILION),
    ):
        plots.note(axes, words, tuple(at[name]), offset, ha="center", va="center", color=color)
    axes.margins(0.02)
    return figure


def _error_figure(sizes: Sequence[int], rows: Sequence[Mapping[str, Any]], largest: _Placed) -> Figure:
    figure = plots.blank(3.4)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "vertices N", "relative error of a length", "determined edges")
    for key, style in plots.styled(("worst", "mean", "median")):
        left.loglog(sizes, [row[key] for row in rows], label=key, **style)
    left.loglog(sizes, [row["used"] for row in rows], color=plots.INK, marker="x", label="used edges, worst")
    plots.legend(left)
    plots.dress(right, "layer", "", f"N = {sizes[-1]:,}")
    free = ~largest.used
    right.semilogy(largest.later_layers[free], largest.errors[free], ".", color=plots.BLUE, markersize=3)
    return figure
