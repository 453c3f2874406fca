"""Two surfaces with the same lengths, and what the convexity routine does (paper, section 2.2, figure 4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.anneal import Annealed
from isoembed.aim.convexity import CORRECTED, PRINTED, popped
from isoembed.aim.paper import Paper
from isoembed.gallery import Sphere, triangulate
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot import Panel, panels
from isoembed.plot.view import Pose, camera
from isoembed.progress.stages import Log, StageRecorder
from isoembed.studies import plots
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.alignment import aligned, distance
from isoembed.surface.convexity import concave_edges, inverted_vertices, umbrella_heights
from isoembed.surface.curvature import dihedral_angles, vertex_mean_curvature
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.rigidity import LengthSystem

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

AXES = (1.3, 1.15, 1.0)  # the hull of a sphere's points, stretched: convex, and with a longest axis to view
EXACT = 1e-13  # mean edge lengths
SHOWN = np.array([0.15, 0.45, 0.85])  # right, up, toward the viewer: about where the vertex is that is drawn
PENTAGON = 5


@dataclass(frozen=True)
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
        heights = umbrella_heights(self.metric.triangulation, vertices)
        return float(heights[self.vertex] / self.metric.mean_length)

    def concave(self, vertices: Floats) -> int:
        """Concave edges of the surface."""
        return int(concave_edges(self.metric.triangulation, vertices).sum())

    def is_inverted(self, vertices: Floats) -> bool:
        """Whether all edges at the vertex are concave."""
        t = self.metric.triangulation
        return bool(inverted_vertices(t, concave_edges(t, vertices))[self.vertex])


def study(*, vertices: int) -> Section:
    """Invert one vertex, and apply the convexity routine as printed and as corrected.

    Parameters
    ----------
    vertices : int
        Of the convex surface; each of them is inverted in turn.

    Returns
    -------
    Section
    """
    convex, faces = _convex_body(vertices)
    metric = PolyhedralMetric.from_mesh(convex, faces)
    system = LengthSystem(metric.triangulation)
    pairs = [pair for v in range(vertices) if (pair := _inverted(metric, system, convex, v)) is not None]
    toward = Pose.of(convex).put(convex) @ camera().T @ SHOWN
    # A vertex with five edges stands out farther than the others.
    front = np.where(metric.triangulation.degrees == PENTAGON, toward, -np.inf)
    shown = max(pairs, key=lambda pair: front[pair.vertex])
    facts = _facts(shown)
    steps = _routine(shown)
    everywhere = _everywhere(pairs)
    deeper, out = steps["printed"], steps["corrected"]
    return Section(
        title="An inverted vertex",
        text=(
            f"Lengths do not decide a polyhedron. On a convex one with {vertices} vertices, one vertex is "
            "mirrored in the plane of its neighbors, and Newton's method brings the lengths back. That "
            f"leaves two surfaces whose lengths agree to {facts['lengths']:.0e} of the mean edge and whose "
            f"deficits agree to {facts['deficits']:.0e} radians, while dihedral angles differ by up to "
            f"{np.degrees(facts['dihedral']):.0f} degrees.",
            "The convexity routine is to pop the vertex out. With v_diff = v - v_avg, the difference from "
            "the mean of its neighbors, the paper prints v_new = v + 2 v_diff. From an inverted vertex that "
            f"leads further in: its height goes from {facts['height_inverted']:+.3f} to "
            f"{deeper['moved']:+.3f} mean edges, three times as deep. v - 2 v_diff leads to "
            f"{out['moved']:+.3f}, and annealing from there to {out['annealed']:+.3f}, the height on the "
            "convex surface.",
        ),
        figures=(
            Illustration(
                "inverted-vertex",
                "Two surfaces with the same lengths and the same deficits. Left: one vertex is inverted. "
                "Right: convex.",
                _surfaces(shown),
            ),
            Illustration(
                "convexity-routine",
                "A section through the inverted vertex along two of its edges. The arrows are the paper's "
                "v + 2 v_diff and the corrected v - 2 v_diff; the dashed line is the convex surface.",
                _section_figure(shown),
            ),
        ),
        comparisons=(
            Comparison(
                "Two polyhedra with identical lengths and Gaussian curvatures (figure 4)",
                "identical",
                f"lengths to {facts['lengths']:.0e} of the mean edge, deficits to {facts['deficits']:.0e}; "
                f"int H dA = {facts['integral_convex']:.4f} and {facts['integral_inverted']:.4f}",
            ),
            Comparison(
                "The convexity routine, v + 2 v_diff (section 2.2)",
                'close to the "popped out" solution',
                f"{everywhere['inverted']} of the {vertices} vertices can be inverted so; as printed, "
                f"{everywhere['printed']} of them are popped, with v - 2 v_diff {everywhere['corrected']}",
                "The sign is wrong: v_diff points inward where the vertex is inverted.",
            ),
            Comparison(
                "Popping is local: all other vertices keep their coordinates (section 2.2)",
                "they do",
                f"on this surface the others move by up to {facts['others_moved']:.3f} mean edges, the "
                f"vertex by {facts['vertex_moved']:.3f}",
                "It would be local if the neighbors lay in a plane.",
            ),
        ),
        tables=(
            Table(
                "Height of the vertex above the mean of its neighbors, in mean edge lengths, and concave "
                "edges of the surface",
                ("", "height", "concave edges", "annealed: height", "concave edges"),
                (
                    ("convex", f"{facts['height_convex']:+.3f}", str(shown.concave(shown.convex)), "", ""),
                    (
                        "inverted",
                        f"{facts['height_inverted']:+.3f}",
                        str(shown.concave(shown.inverted)),
                        "",
                        "",
                    ),
                    *(
                        (
                            name,
                            f"{step['moved']:+.3f}",
                            str(step["moved_concave"]),
                            f"{step['annealed']:+.3f}",
                            str(step["annealed_concave"]),
                        )
                        for name, step in (
                            ("v + 2 v_diff, printed", deeper),
                            ("v - 2 v_diff, corrected", out),
                        )
                    ),
                ),
            ),
        ),
        numbers={"pair": facts, "routine": steps, "every_vertex": everywhere},
    )


def _convex_body(n: int) -> tuple[Floats, NDArray[np.int64]]:
    vertices, faces = triangulate(Sphere(), n)
    return vertices * AXES, faces


def _annealed(metric: PolyhedralMetric, system: LengthSystem, vertices: Floats) -> Annealed:
    return Paper().anneal(
        system, vertices, metric.lengths, EXACT * metric.mean_length, StageRecorder("anneal", Log())
    )


def _inverted(metric: PolyhedralMetric, system: LengthSystem, convex: Floats, v: int) -> _Pair | None:
    """Find the surface with vertex v inverted, if Newton's method leads there."""
    neighbors = metric.triangulation.adjacency[[v]].indices
    middle = convex[neighbors].mean(axis=0)
    normal = np.linalg.svd(convex[neighbors] - middle)[2][2]  # of the plane nearest to the neighbors
    mirrored = convex.copy()
    mirrored[v] -= 2 * ((convex[v] - middle) @ normal) * normal
    found = _annealed(metric, system, mirrored)
    pair = _Pair(metric, system, convex, v, aligned(found.vertices, convex))
    return pair if found.converged and pair.is_inverted(pair.inverted) else None


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
        "vertex_moved": distance(pair.inverted, pair.convex) / unit,
    }


def _routine(pair: _Pair) -> dict[str, dict[str, float]]:
    """Heights and concave edges after both routines, before and after annealing."""
    steps = {}
    for name, sign in (("printed", PRINTED), ("corrected", CORRECTED)):
        moved = popped(pair.metric.triangulation, pair.inverted, pair.which, sign)
        annealed = _annealed(pair.metric, pair.system, moved)
        steps[name] = {
            "moved": pair.height(moved),
            "moved_concave": pair.concave(moved),
            "annealed": pair.height(annealed.vertices),
            "annealed_concave": pair.concave(annealed.vertices),
            "residual": annealed.residual / pair.metric.mean_length,
        }
    return steps


def _everywhere(pairs: list[_Pair]) -> dict[str, int]:
    """How many vertices can be inverted, and how many of them each routine pops out again."""
    counts = {"vertices": len(pairs[0].convex), "inverted": len(pairs), "printed": 0, "corrected": 0}
    for pair in pairs:
        for name, sign in (("printed", PRINTED), ("corrected", CORRECTED)):
            moved = popped(pair.metric.triangulation, pair.inverted, pair.which, sign)
            annealed = _annealed(pair.metric, pair.system, moved)
            counts[name] += int(annealed.converged and pair.concave(annealed.vertices) == 0)
    return counts


def _surfaces(pair: _Pair) -> Figure:
    t = pair.metric.triangulation
    rows = [
        Panel(x, t.faces, vertex_mean_curvature(t, x), title)
        for x, title in ((pair.inverted, "one vertex inverted"), (pair.convex, "convex"))
    ]
    shown = np.concatenate([panel.values[t.faces].mean(axis=1) for panel in rows])
    return panels(
        rows,
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
        return float((vertices[vertex] - middle) @ first / unit), float(
            (vertices[vertex] - middle) @ normal / unit
        )

    def beyond(vertex: int) -> int:
        """The neighbor that continues the section, away from v."""
        ring = t.adjacency[[vertex]].indices
        away = pair.inverted[vertex] - middle
        return int(ring[((pair.inverted[ring] - middle) @ away).argmax()])

    chain = [beyond(left), left, v, right, beyond(right)]
    moved = {
        name: popped(t, pair.inverted, pair.which, sign)
        for name, sign in (("printed", PRINTED), ("corrected", CORRECTED))
    }
    figure = plots.blank(4.2)
    axes = figure.add_subplot()
    plots.bare(axes)
    axes.axhline(0, color=plots.GRID, linewidth=1.0)
    axes.plot(*zip(*(at(w, pair.convex) for w in chain), strict=True), "--", color=plots.INK, linewidth=1.2)
    axes.plot(*zip(*(at(w, pair.inverted) for w in chain), strict=True), "-", color=plots.INK, linewidth=1.8)
    start = at(v, pair.inverted)
    axes.plot(*start, "o", color=plots.INK, markersize=7)
    axes.annotate("v, inverted", start, xytext=(12, -10), textcoords="offset points", color=plots.INK)
    for name, color, word, shift in (
        ("printed", plots.VERMILION, r"$v + 2\,v_{diff}$, as printed", -6),
        ("corrected", plots.BLUE, r"$v - 2\,v_{diff}$, corrected", 9),
    ):
        end = at(v, moved[name])
        for side in (left, right):
            ends = zip(at(side, pair.inverted), end, strict=True)
            axes.plot(*ends, ":", color=color, linewidth=1.4)
        axes.annotate(
            "", end, (start[0], start[1]), arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.6}
        )
        axes.plot(*end, "o", color=color, markersize=7)
        axes.annotate(word, end, xytext=(10, shift), textcoords="offset points", color=color, va="center")
    axes.annotate(
        "mean of the neighbors",
        (at(chain[0], pair.inverted)[0], 0),
        xytext=(-30, 6),
        textcoords="offset points",
        ha="left",
        color=plots.FAINT,
        fontsize=plots.SMALL,
    )
    axes.margins(0.06)
    return figure
