"""Two surfaces with the same lengths, and what the convexity routine does (paper, section 2.2, figure 4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import Embedding, Paper, PolyhedralMetric
from isoembed.aim.anneal import Annealed
from isoembed.gallery import Sphere
from isoembed.metric.curvature import deficits
from isoembed.plot import Panel, panels
from isoembed.progress.stages import Log
from isoembed.surface.alignment import aligned
from isoembed.surface.curvature import dihedral_angles, vertex_mean_curvature
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.rigidity import LengthSystem
from reproduction import plots
from reproduction.arrays import Floats, Mask
from reproduction.bodies import meshed
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure


AXES = (1.3, 1.15, 1.0)  # the hull of a sphere's points, stretched: convex, and with a longest axis to view
SHOWN = np.array([0.55, -0.74, 1.0])  # about where the vertex is that is drawn: pictures are seen from there
PENTAGON = 5  # edges at the vertex that is drawn
ROUTINES = {"printed": 1.0, "corrected": -1.0}  # the sign in v +- 2 v_diff
EXACT = 1e-13  # mean edge lengths: tolerance of the residuals of two surfaces with the same lengths


@dataclass(frozen=True, eq=False)
class _Pair:
    """A convex surface, and one with the same lengths and one vertex turned inside out."""

    metric: PolyhedralMetric
    system: LengthSystem
    convex: Floats
    vertex: int
    inverted: Floats

    @property
    def which(self) -> Mask:
        """Only that vertex."""
        return np.arange(len(self.convex)) == self.vertex

    def height(self, vertices: Floats) -> float:
        """How far the vertex stands above the mean of its neighbors, in mean edge lengths."""
        t, v = self.metric.triangulation, self.vertex
        mean = (t.adjacency[[v]] @ vertices)[0] / t.degrees[v]
        return float((vertices[v] - mean) @ vertex_normals(t.faces, vertices)[v] / self.metric.mean_length)

    def concave(self, vertices: Floats) -> int:
        """Number of concave edges."""
        return int(_measured(self.metric, vertices).surface.concave_edges.sum())

    @cached_property
    def moved(self) -> dict[str, Floats]:
        """The inverted surface after each routine, before annealing."""
        t = self.metric.triangulation
        difference = self.inverted - (t.adjacency @ self.inverted) / t.degrees[:, None]
        return {
            name: np.where(self.which[:, None], self.inverted + sign * 2 * difference, self.inverted)
            for name, sign in ROUTINES.items()
        }

    @cached_property
    def annealed(self) -> dict[str, Annealed]:
        """And after it."""
        return {name: _annealed(self.metric, self.system, x) for name, x in self.moved.items()}


def study(*, vertices: int) -> Section:
    """One vertex inverted, and the convexity routine as printed and as corrected.

    Parameters
    ----------
    vertices : int
        Of the convex surface; each of them is inverted in turn.
    """
    sphere = meshed(Sphere(), vertices)
    convex = sphere.vertices * AXES
    metric = PolyhedralMetric.from_mesh(convex, sphere.metric.faces)
    system = LengthSystem(metric.triangulation)
    pairs = [pair for v in range(vertices) if (pair := _inverted(metric, system, convex, v)) is not None]
    toward = convex @ SHOWN
    # A vertex with five edges stands out farther than the others.
    front = np.where(metric.triangulation.degrees == PENTAGON, toward, -np.inf)
    shown = max(pairs, key=lambda pair: front[pair.vertex])
    facts = _facts(shown)
    steps = {name: _step(shown, name) for name in ROUTINES}
    deeper, out = steps["printed"], steps["corrected"]
    popped_out = {name: sum(_is_popped(pair, name) for pair in pairs) for name in ROUTINES}
    everywhere = {"vertices": vertices, "inverted": len(pairs), **popped_out}
    rows = [
        {"name": name, "height": shown.height(x), "concave": shown.concave(x)}
        | {"annealed": "", "annealed_concave": ""}
        for name, x in (("convex", shown.convex), ("inverted", shown.inverted))
    ]
    rows += [
        {
            "name": f"v {sign} 2 v_diff, {name}",
            "height": step["moved"],
            "concave": step["moved_concave"],
            "annealed": f"{step['annealed']:+.3f}",
            "annealed_concave": step["annealed_concave"],
        }
        for sign, (name, step) in zip("+-", steps.items(), strict=True)
    ]
    return Section.of(
        "inverted-vertex",
        figures={"inverted-vertex": _surfaces(shown), "convexity-routine": _section_figure(shown)},
        numbers={"pair": facts, "routine": steps, "every_vertex": everywhere},
        vertices=vertices,
        facts=facts,
        degrees=np.degrees(facts["dihedral"]),
        deeper=deeper,
        out=out,
        everywhere=everywhere,
        rows=rows,
    )


def _annealed(metric: PolyhedralMetric, system: LengthSystem, vertices: Floats) -> Annealed:
    with Log().stage("anneal") as recorder:
        return Paper().anneal(system, vertices, metric.lengths, EXACT * metric.mean_length, recorder)


def _measured(metric: PolyhedralMetric, vertices: Floats) -> Embedding:
    return Embedding(metric, vertices, method="annealed", tolerance=EXACT)


def _inverted(metric: PolyhedralMetric, system: LengthSystem, convex: Floats, v: int) -> _Pair | None:
    """The surface with vertex v inverted, if Newton's method leads there."""
    neighbors = metric.triangulation.adjacency[[v]].indices
    middle = convex[neighbors].mean(axis=0)
    normal = np.linalg.svd(convex[neighbors] - middle)[2][2]  # of the plane nearest to the neighbors
    mirrored = convex.copy()
    mirrored[v] -= 2 * ((convex[v] - middle) @ normal) * normal
    found = _annealed(metric, system, mirrored)
    inverted = aligned(found.vertices, convex)
    turned = _measured(metric, inverted).surface.inverted_vertices[v]
    return _Pair(metric, system, convex, v, inverted) if found.converged and turned else None


def _facts(pair: _Pair) -> dict[str, float]:
    t, unit = pair.metric.triangulation, pair.metric.mean_length
    lengths = [edge_lengths(t.edges, x) for x in (pair.convex, pair.inverted)]
    curved = [deficits(pair.metric.with_lengths(l)) for l in lengths]
    folds = [dihedral_angles(t, x) for x in (pair.convex, pair.inverted)]
    others = ~pair.which
    onto = aligned(pair.inverted[others], pair.convex[others])
    return {
        "lengths": float(np.abs(lengths[0] - lengths[1]).max() / unit),
        "deficits": float(np.abs(curved[0] - curved[1]).max()),
        "dihedral": float(np.abs(folds[0] - folds[1]).max()),
        "height_convex": pair.height(pair.convex),
        "height_inverted": pair.height(pair.inverted),
        "integral_convex": float(lengths[0] @ folds[0] / 2),
        "integral_inverted": float(lengths[1] @ folds[1] / 2),
        "others_moved": float(np.linalg.norm(onto - pair.convex[others], axis=1).max() / unit),
        "vertex_moved": _measured(pair.metric, pair.inverted).distance(_measured(pair.metric, pair.convex)),
    }


def _step(pair: _Pair, routine: str) -> dict[str, Any]:
    """Heights and concave edges after a routine, before and after annealing."""
    moved, annealed = pair.moved[routine], pair.annealed[routine]
    return {
        "moved": pair.height(moved),
        "moved_concave": pair.concave(moved),
        "annealed": pair.height(annealed.vertices),
        "annealed_concave": pair.concave(annealed.vertices),
        "residual": annealed.residual / pair.metric.mean_length,
    }


def _is_popped(pair: _Pair, routine: str) -> bool:
    annealed = pair.annealed[routine]
    return annealed.converged and pair.concave(annealed.vertices) == 0


def _surfaces(pair: _Pair) -> Figure:
    t = pair.metric.triangulation
    row = [
        Panel(x, t.faces, vertex_mean_curvature(t, x), title)
        for x, title in ((pair.inverted, "one vertex inverted"), (pair.convex, "convex"))
    ]
    shown = np.concatenate([panel.values[t.faces].mean(axis=1) for panel in row])
    return panels(
        row,
        label="mean curvature  $H$",
        bounds=(float(shown.min()), float(shown.max())),
        caption=f"{t.n_vertices} vertices, the same {t.n_edges} lengths",
    )


def _section_figure(pair: _Pair) -> Figure:
    """The vertex with two opposite neighbors and their next ones, seen from the side."""
    t, unit, v = pair.metric.triangulation, pair.metric.mean_length, pair.vertex
    neighbors = t.adjacency[[v]].indices
    normal = vertex_normals(t.faces, pair.convex)[v]
    normal = normal / np.linalg.norm(normal)
    middle = pair.inverted[neighbors].mean(axis=0)
    flat = pair.inverted[neighbors] - middle
    flat = flat - np.outer(flat @ normal, normal)
    first = flat[0] / np.linalg.norm(flat[0])
    left, right = neighbors[(flat @ first).argmin()], neighbors[0]

    def at(vertex: int, vertices: Floats) -> tuple[float, float]:
        away = vertices[vertex] - middle
        return float(away @ first / unit), float(away @ normal / unit)

    def beyond(vertex: int) -> int:
        """The neighbor that continues the section, away from v."""
        ring = t.adjacency[[vertex]].indices
        away = pair.inverted[vertex] - middle
        return int(ring[((pair.inverted[ring] - middle) @ away).argmax()])

    chain = [beyond(left), left, v, right, beyond(right)]
    figure = plots.blank(4.2)
    axes = figure.add_subplot()
    plots.bare(axes)
    axes.axhline(0, color=plots.GRID, linewidth=1.0)
    for vertices, line, width in ((pair.convex, "--", 1.2), (pair.inverted, "-", 1.8)):
        axes.plot(
            *zip(*(at(w, vertices) for w in chain), strict=True), line, color=plots.INK, linewidth=width
        )
    start = at(v, pair.inverted)
    axes.plot(*start, "o", color=plots.INK, markersize=7)
    plots.note(axes, "v, inverted", start, (12, -10))
    for name, color, words, shift in (
        ("printed", plots.VERMILION, r"$v + 2\,v_{diff}$, as printed", -6),
        ("corrected", plots.BLUE, r"$v - 2\,v_{diff}$, corrected", 9),
    ):
        end = at(v, pair.moved[name])
        for side in (left, right):
            axes.plot(*zip(at(side, pair.inverted), end, strict=True), ":", color=color, linewidth=1.4)
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.6})
        axes.plot(*end, "o", color=color, markersize=7)
        plots.note(axes, words, end, (10, shift), color=color, va="center")
    mean = (at(chain[0], pair.inverted)[0], 0.0)
    plots.note(axes, "mean of the neighbors", mean, (-30, 6), color=plots.FAINT, fontsize=plots.SMALL)
    axes.margins(0.06)
    return figure
