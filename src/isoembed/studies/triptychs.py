"""Exact, smooth and crumpled (paper, figures 6 and 9): three surfaces with the same lengths, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from isoembed._embed import Method, embed
from isoembed.aim.anneal import anneal_damped
from isoembed.aim.paper import Paper
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.gallery.surface import Surface
from isoembed.meshing.directions import directions_of
from isoembed.metric.curvature import negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot import Panel, panels
from isoembed.progress.stages import Log, StageRecorder
from isoembed.studies.bodies import attempted
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.alignment import aligned
from isoembed.surface.embedding import Embedding
from isoembed.surface.measures import vertex_normals
from isoembed.surface.rigidity import LengthSystem

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

TOLERANCE = 1e-6  # the paper's
CRUMPLED = 0.05  # share of rough edges from which on a surface is called crumpled
FEW = (1, 2)  # steps of the pull-back
KICKS = (0.3, 0.2, 0.1)  # mean edge lengths
LONGEST = 150  # iterations of the damped annealing after a kick
SHOWN = (2.0, 97.0)  # percentiles of the exact H between which the colors run: the tips have far more


@dataclass(frozen=True)
class Attempt:
    """One way to a crumpled surface, and where it led."""

    how: str
    surface: Embedding

    @property
    def succeeded(self) -> bool:
        """Whether the surface has the given lengths and is crumpled."""
        return self.surface.converged and self.share >= CRUMPLED

    @property
    def share(self) -> float:
        """Rough edges over edges."""
        return float(self.surface.rough_edges.mean())


@dataclass(frozen=True)
class Triptych:
    """The three panels of one surface.

    Attributes
    ----------
    surface : Surface
    exact : Embedding
        The vertices that the lengths were taken from.
    mean_curvature : ndarray, shape (V,)
        Exact, at those vertices.
    smooth : Embedding
        From the lengths alone.
    attempts : tuple of Attempt
        At a crumpled surface, the last one being shown.
    """

    surface: Surface
    exact: Embedding
    mean_curvature: Floats
    smooth: Embedding
    attempts: tuple[Attempt, ...]

    @property
    def crumpled(self) -> Embedding:
        """The right panel."""
        return self.attempts[-1].surface

    def percent(self, surface: Embedding) -> float:
        """Error of int H dA, in percent of the smooth surface's."""
        return 100 * (surface.integrated_mean_curvature / self.surface.integrated_mean_curvature - 1)

    def numbers(self, surface: Embedding) -> dict[str, Any]:
        """What is said about a panel."""
        return {
            "residual": surface.residual,
            "percent_error": self.percent(surface),
            "concave_edges": int(surface.concave_edges.sum()),
            "rough_edges": int(surface.rough_edges.sum()),
            "inverted_vertices": int(surface.inverted_vertices.sum()),
            "partially_inverted_vertices": int(surface.partially_inverted_vertices.sum()),
            "distance": surface.distance(self.exact),
        }


def study(*, ellipsoid: int, drum: int, ergosphere: int) -> Section:
    """Embed the paper's three surfaces smoothly and crumpled.

    Parameters
    ----------
    ellipsoid, drum, ergosphere : int
        Vertices; the paper has 3226 and 3246, and does not give the third.

    Returns
    -------
    Section
    """
    hole = Ergosphere()
    made = [
        triptych(Ellipsoid(), ellipsoid, Paper()),
        triptych(Drum(), drum, Paper()),
        triptych(hole, ergosphere, "aim"),
    ]
    return Section(
        title="Smooth and crumpled embeddings",
        text=(
            "Left: the surface that the lengths were taken from, colored by its exact mean curvature. "
            "Middle: what is found from the lengths alone (ellipsoid and drum: the paper's method, 10 steps, "
            "tolerance 1e-6, with the corrected convexity routine and the start fitted to the sphere; "
            "ergosphere: the default method). Right: another surface with the same lengths, crumpled. One "
            "scale of colors for the three; H = (k1 + k2) / 2.",
            f"The paper does not give the epsilon of its ergosphere; here it is {hole.epsilon:g}, with a = "
            f"{hole.spin:g} and M = {hole.mass:g}.",
            "A crumpled surface must be a realization of the lengths to 1e-6, or it shows nothing. Ways to "
            f"one were tried in this order until one had the lengths and at least {CRUMPLED:.0%} of its "
            "edges rough (bent against their neighborhood): the pull-back in 1 step "
            "and in 2 steps without the convexity routine, as the paper says; then the smooth surface with "
            "each vertex pushed at random along its normal (Gaussian, with the root mean square given) and "
            "annealed, damped, without the convexity routine. Where K < 0 somewhere, only vertices far from "
            "there are moved: with the others moved, too, the annealing gets stuck.",
        ),
        figures=tuple(
            Illustration(
                f"triptych-{one.surface.name}",
                f"{one.surface.name.capitalize()}, {len(one.mean_curvature):,} vertices. Left: exact. "
                f"Middle: from the lengths alone, {one.smooth.distance(one.exact):.0e} mean edge lengths "
                f"from the vertices that were thrown away. Right: {_right(one)}.",
                picture(one),
            )
            for one in made
        ),
        comparisons=tuple(_comparisons({one.surface.name: one for one in made})),
        tables=(
            Table(
                f"Ways to a crumpled surface, tried until one had the lengths to {TOLERANCE:.0e}",
                ("surface", "way", "residual", "rough edges", "outcome"),
                tuple(
                    (
                        one.surface.name,
                        attempt.how,
                        f"{attempt.surface.residual:.0e}",
                        f"{attempt.share:.1%}",
                        _verdict(attempt),
                    )
                    for one in made
                    for attempt in one.attempts
                ),
            ),
            Table(
                "The panels. Distances are the largest of a vertex, after the best rigid motion, in mean "
                "edge lengths",
                (
                    "surface",
                    "panel",
                    "residual",
                    "error of int H dA",
                    "concave edges",
                    "rough edges",
                    "inverted",
                    "partially",
                    "distance",
                ),
                tuple(row for one in made for row in _rows(one)),
            ),
        ),
        numbers={
            one.surface.name: {
                "vertices": len(one.mean_curvature),
                "exact": one.numbers(one.exact),
                "smooth": {**one.numbers(one.smooth), "method": one.smooth.method},
                "crumpled": {**one.numbers(one.crumpled), "how": one.attempts[-1].how},
                "attempts": [
                    {"how": a.how, "residual": a.surface.residual, "rough": a.share} for a in one.attempts
                ],
            }
            for one in made
        },
    )


def triptych(surface: Surface, vertices: int, method: str | Method) -> Triptych:
    """Embed a surface's lengths smoothly and crumpled.

    Parameters
    ----------
    surface : Surface
    vertices : int
    method : str or Method
        Of the smooth embedding, at the paper's tolerance.

    Returns
    -------
    Triptych
    """
    points, faces = triangulate(surface, vertices)
    metric = PolyhedralMetric.from_mesh(points, faces)
    smooth = embed(metric, method=method, tolerance=TOLERANCE)
    return Triptych(
        surface,
        Embedding(metric, points, method="exact", tolerance=TOLERANCE),
        surface.mean_curvature(directions_of(surface, points)),
        smooth,
        tuple(_attempts(smooth)),
    )


def picture(one: Triptych) -> Figure:
    """The three panels in one row."""
    low, high = np.percentile(one.mean_curvature, SHOWN)
    given, faces = one.exact.vertices, one.exact.faces
    return panels(
        [
            Panel(given, faces, one.mean_curvature, "exact"),
            Panel(aligned(one.smooth.vertices, given), faces, one.smooth.mean_curvature, "from the lengths"),
            Panel(aligned(one.crumpled.vertices, given), faces, one.crumpled.mean_curvature, "crumpled"),
        ],
        label="mean curvature H",
        bounds=(float(low), float(high)),
    )


def _attempts(smooth: Embedding) -> Sequence[Attempt]:
    """Ways to a crumpled surface with the lengths of a smooth one, up to the first that leads there."""
    tried = []
    for steps in FEW:
        surface = attempted(smooth.metric, Paper(Tsteps=steps, convexity="none"), TOLERANCE)
        tried.append(Attempt(f"pull-back in {steps} step{'s' * (steps > 1)}, no convexity routine", surface))
        if tried[-1].succeeded:
            return tried
    for kick in KICKS:
        how = f"random push along the normals by {kick:g} mean edge lengths, then annealing"
        tried.append(Attempt(how, kicked(smooth, kick)))
        if tried[-1].succeeded:
            break
    return tried


def kicked(smooth: Embedding, kick: float) -> Embedding:
    """Move the vertices at random along their normals and anneal the lengths, damped.

    Vertices that are fewer than ``sqrt(V) / 10`` edges from one with negative curvature stay.

    Parameters
    ----------
    smooth : Embedding
    kick : float
        Root mean square of what they are moved by, in mean edge lengths.

    Returns
    -------
    Embedding
        Whatever the annealing came to.
    """
    metric, t = smooth.metric.normalized, smooth.triangulation
    points = smooth.vertices / smooth.metric.unit
    held = negative_deficits(metric)
    for _ in range(round(np.sqrt(t.n_vertices) / 10)):
        held = held | (t.adjacency @ held > 0)
    normals = vertex_normals(t.faces, points)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = kick * metric.mean_length * np.random.default_rng(0).normal(size=t.n_vertices)
    annealed = anneal_damped(
        LengthSystem(t),
        points + np.where(held, 0.0, heights)[:, None] * normals,
        metric.lengths,
        StageRecorder("anneal", Log()),
        residual_tolerance=TOLERANCE,
        max_iterations=LONGEST,
    )
    return Embedding(
        smooth.metric, annealed.vertices * smooth.metric.unit, method="kicked", tolerance=TOLERANCE
    )


def _right(one: Triptych) -> str:
    """What the right panel shows."""
    residual = f"{one.crumpled.residual:.0e}"
    if one.attempts[-1].succeeded:
        return f"a crumpled surface with the same lengths to {residual}, made by: {one.attempts[-1].how}"
    return f"the last attempt at a crumpled surface, which has the residual {residual}"


def _verdict(attempt: Attempt) -> str:
    if attempt.succeeded:
        return "crumpled, with the lengths"
    if not attempt.surface.converged:
        return "misses the lengths"
    return f"less than {CRUMPLED:.0%} rough" if attempt.share else "smooth"


def _rows(one: Triptych) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for panel, surface in (("exact", one.exact), ("smooth", one.smooth), ("crumpled", one.crumpled)):
        n = one.numbers(surface)
        rows.append(
            (
                one.surface.name,
                panel,
                f"{n['residual']:.1e}",
                f"{n['percent_error']:+.3f} %",
                f"{n['concave_edges']:,}",
                f"{n['rough_edges']:,}",
                str(n["inverted_vertices"]),
                str(n["partially_inverted_vertices"]),
                f"{n['distance']:.1e}",
            )
        )
    return rows


def _comparisons(made: dict[str, Triptych]) -> list[Comparison]:
    smooth = {name: one.numbers(one.smooth) for name, one in made.items()}
    kerr = made["ergosphere"]
    return [
        Comparison(
            "Smooth embeddings look like the continuum (figures 6 and 9): distance of a vertex from the "
            "discarded one",
            "compared by eye",
            "; ".join(
                f"{name}: {n['distance']:.0e} mean edge lengths (method {made[name].smooth.method})"
                for name, n in smooth.items()
            ),
        ),
        Comparison(
            "Realizations that the method can produce do not vary significantly (section 4)",
            "observed, especially at higher resolutions",
            "; ".join(
                f"{name}: the crumpled one is {n['distance']:.2g} mean edge lengths away, "
                f"{n['percent_error']:+.2f} % in int H dA against {smooth[name]['percent_error']:+.3f} %"
                for name, n in ((name, one.numbers(one.crumpled)) for name, one in made.items())
            ),
            "With its guidance the method ends on the smooth one. Without it surfaces with the same lengths "
            "can be this far apart.",
        ),
        Comparison(
            "Without adiabaticity and the convexity routine the embedding is not smooth (figures 6 and 9)",
            "crumpled surfaces, residuals not stated",
            "; ".join(
                f"{name}: {one.attempts[-1].how}, residual {one.crumpled.residual:.0e}, "
                f"{one.attempts[-1].share:.0%} of the edges rough, {one.percent(one.crumpled):+.2f} % in "
                "int H dA"
                for name, one in made.items()
            ),
            _why_crumpled(made),
        ),
        Comparison(
            "Error of int H dA of the ergosphere (section 3.2)",
            "0.62 %",
            f"{smooth['ergosphere']['percent_error']:+.3f} % at {len(kerr.mean_curvature):,} vertices; "
            f"{kerr.percent(kerr.exact):+.3f} % for the exact coordinates",
            "The paper gives neither the resolution nor epsilon. The error is that of a polyhedron inscribed "
            "in the surface, not of the embedding, and falls like 1 / N.",
        ),
    ]


def _why_crumpled(made: dict[str, Triptych]) -> str:
    other = [name for name, one in made.items() if not one.attempts[-1].how.startswith("pull-back")]
    if not other:
        return ""
    return (
        f"For the {' and the '.join(other)} a pull-back in 1 or 2 steps is smooth or gets stuck short of the "
        "lengths here, so a crumpled surface is made from a pushed one."
    )
