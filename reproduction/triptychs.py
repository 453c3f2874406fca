"""Exact, smooth and crumpled (paper, figures 6 and 9): three surfaces with the same lengths, side by side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import Embedding, Paper
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, Surface
from isoembed.meshing import directions_of
from isoembed.metric.curvature import negative_deficits
from isoembed.plot import Panel, panels
from isoembed.surface.alignment import aligned
from isoembed.surface.measures import vertex_normals
from reproduction.arrays import Floats
from reproduction.bodies import TOLERANCE, Body, attempted, embedding_of, meshed
from reproduction.levenberg_marquardt import least_squares
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure


CRUMPLED = 0.05  # share of rough edges from which on a surface is called crumpled
FEW = (1, 2)  # steps of the pull-back
ITERATIONS = 150  # after the random push
KICKS = (0.3, 0.2, 0.1)  # mean edge lengths
SHOWN = (2.0, 97.0)  # percentiles of the exact H between which the colors run: the tips have far more


@dataclass(frozen=True)
class Attempt:
    """One way to a crumpled surface, and where it led."""

    how: str
    surface: Embedding

    @property
    def share(self) -> float:
        """Rough edges over edges."""
        return float(self.surface.surface.rough_edges.mean())

    @property
    def succeeded(self) -> bool:
        """Whether the surface has the given lengths and is crumpled."""
        return self.surface.converged and self.share >= CRUMPLED

    @property
    def verdict(self) -> str:
        """What came of it, in a few words."""
        if self.succeeded:
            return "crumpled, with the lengths"
        if not self.surface.converged:
            return "misses the lengths"
        return f"less than {CRUMPLED:.0%} rough" if self.share else "smooth"

    @property
    def numbers(self) -> dict[str, Any]:
        """The way, and how near it led."""
        return {"how": self.how, "residual": self.surface.residual, "rough": self.share}


@dataclass(frozen=True)
class Triptych:
    """The three panels of one surface.

    Attributes
    ----------
    body : Body
        The surface, and the vertices that the lengths were taken from.
    mean_curvature : ndarray, shape (V,)
        Exact, at those vertices.
    smooth : Embedding
        From the lengths alone.
    attempts : tuple of Attempt
        At a crumpled surface, the last one being shown.
    """

    body: Body
    mean_curvature: Floats
    smooth: Embedding
    attempts: tuple[Attempt, ...]

    @property
    def name(self) -> str:
        """The surface's."""
        return self.body.surface.name

    @property
    def panels(self) -> dict[str, Embedding]:
        """The exact, the smooth and the crumpled surface."""
        return {"exact": self.body.exact, "smooth": self.smooth, "crumpled": self.attempts[-1].surface}

    @property
    def numbers(self) -> dict[str, Any]:
        """What is said about each panel and each attempt."""
        said: dict[str, dict[str, Any]] = {
            panel: {
                "residual": surface.residual,
                "percent_error": self.body.percent_error(surface.integrated_mean_curvature),
                "concave_edges": int(surface.surface.concave_edges.sum()),
                "rough_edges": int(surface.surface.rough_edges.sum()),
                "inverted_vertices": int(surface.surface.inverted_vertices.sum()),
                "partially_inverted_vertices": int(surface.surface.partially_inverted_vertices.sum()),
                "distance": surface.distance(self.body.exact),
            }
            for panel, surface in self.panels.items()
        }
        said["smooth"]["method"] = self.smooth.method
        said["crumpled"]["how"] = self.attempts[-1].how
        attempts = [attempt.numbers for attempt in self.attempts]
        return {"vertices": len(self.mean_curvature), **said, "attempts": attempts}


def study(*, ellipsoid: int, drum: int, ergosphere: int) -> Section:
    """The paper's three surfaces, embedded smoothly and crumpled.

    Parameters
    ----------
    ellipsoid, drum, ergosphere : int
        Vertices; the paper has 3226 and 3246, and does not give the third.
    """
    hole = Ergosphere()
    made = [
        triptych(Ellipsoid(), ellipsoid, Paper()),
        triptych(Drum(), drum, Paper()),
        triptych(hole, ergosphere, "aim"),
    ]
    numbers = {one.name: one.numbers for one in made}
    records = [{"name": one.name, "rough": one.attempts[-1].share, **numbers[one.name]} for one in made]
    return Section.of(
        "triptychs",
        figures={f"triptych-{one.name}": picture(one) for one in made},
        numbers=numbers,
        tolerance=TOLERANCE,
        attempts=[
            {"name": one.name, "verdict": attempt.verdict, **attempt.numbers}
            for one in made
            for attempt in one.attempts
        ],
        panels=[
            {"name": record["name"], "panel": panel, **record[panel]}
            for record in records
            for panel in ("exact", "smooth", "crumpled")
        ],
        hole=hole,
        share=CRUMPLED,
        records=records,
        pushed=_why_crumpled([one.name for one in made if "pull-back" not in one.attempts[-1].how]),
        kerr=records[-1],
        captions={one.name: _caption(one) for one in made},
    )


def triptych(surface: Surface, vertices: int, method: str | Paper) -> Triptych:
    """A surface's lengths embedded smoothly, by this method to the paper's tolerance, and crumpled."""
    body = meshed(surface, vertices)
    smooth = embedding_of(body, method, TOLERANCE)
    curvature = surface.mean_curvature(directions_of(surface, body.vertices))
    attempts: list[Attempt] = []
    for attempt in _attempts(smooth):
        attempts.append(attempt)
        if attempt.succeeded:
            break
    return Triptych(body, curvature, smooth, tuple(attempts))


def _attempts(smooth: Embedding) -> Iterator[Attempt]:
    """Ways to a crumpled surface with the lengths of a smooth one."""
    for steps in FEW:
        surface = attempted(smooth.metric, Paper(Tsteps=steps, convexity="none"), TOLERANCE)
        yield Attempt(f"pull-back in {steps} step{'s' * (steps > 1)}, no convexity routine", surface)
    for kick in KICKS:
        how = f"random push along the normals by {kick:g} mean edge lengths, then annealing"
        yield Attempt(how, kicked(smooth, kick))


def picture(one: Triptych) -> Figure:
    """The three panels in one row."""
    low, high = np.percentile(one.mean_curvature, SHOWN)
    exact, smooth, crumpled = one.panels.values()
    row = [Panel(exact.vertices, exact.faces, one.mean_curvature, "exact")]
    for surface, title in ((smooth, "from the lengths"), (crumpled, "crumpled")):
        vertices = aligned(surface.vertices, exact.vertices)
        row.append(Panel(vertices, exact.faces, surface.mean_curvature, title))
    return panels(row, label="mean curvature H", bounds=(float(low), float(high)))


def kicked(smooth: Embedding, kick: float) -> Embedding:
    """The vertices moved at random along their normals and annealed to the lengths, damped.

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
    start = points + np.where(held, 0.0, heights)[:, None] * normals
    return least_squares(
        smooth.metric, start, method="kicked", tolerance=TOLERANCE, max_iterations=ITERATIONS
    )


def _caption(one: Triptych) -> str:
    last = one.attempts[-1]
    residual = f"{last.surface.residual:.0e}"
    right = f"the last attempt at a crumpled surface, which has the residual {residual}"
    if last.succeeded:
        right = f"a crumpled surface with the same lengths to {residual}, made by: {last.how}"
    return (
        f"{one.name.capitalize()}, {len(one.mean_curvature):,} vertices. Left: exact. Middle: from the "
        f"lengths alone, {one.smooth.distance(one.body.exact):.0e} mean edge lengths from the vertices that "
        f"were thrown away. Right: {right}."
    )


def _why_crumpled(pushed: list[str]) -> str:
    if not pushed:
        return ""
    return (
        f"For the {' and the '.join(pushed)} a pull-back in 1 or 2 steps is smooth or gets stuck short of "
        "the lengths here, so a crumpled surface is made from a pushed one."
    )
