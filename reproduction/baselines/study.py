"""The section on the cited methods: the table, their convergence, and one metric's surfaces in a row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.plot import Panel, panels
from isoembed.smooth import Harmonics
from isoembed.surface.alignment import aligned
from reproduction import plots
from reproduction.baselines.embedding_flow import STAGES, embedding_flow
from reproduction.baselines.spherical_harmonics import HarmonicMap
from reproduction.baselines.subjects import Problem, paper_subjects, saddled
from reproduction.baselines.table import (
    BUMPS,
    FOUND,
    OTHER,
    ROUGH,
    SHORT,
    TRUTH,
    WORSE,
    Run,
    compare,
    fitted,
    run_table,
    searches,
)
from reproduction.baselines.uniformization import uniformized
from reproduction.section import Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEARCHED = 8  # degree of the harmonics that are fitted from many starts
SIZES = (0.1, 0.3, 0.5)  # of the bumps of these starts, in radii
FLOWED = Harmonics(24, 1)  # for the horizon, which is symmetric about z
FLOOR = 1e-9  # mean edge lengths: smaller residuals of the flow are not due to the steps alone
HALVINGS = 6  # numbers of steps 1, 2, 4, ...
SHOWN = {
    TRUTH: "true surface",
    "wire frame, from a sphere": "wire frame",
    "harmonics, from a bumpy sphere": "harmonics",
    "embedding flow": "embedding flow",
    "isoembed, aim": "isoembed",
}


@dataclass(frozen=True)
class Curve:
    """Residuals over degrees or numbers of steps."""

    label: str
    x: Sequence[int]
    residuals: Sequence[float]

    @property
    def order(self) -> float:
        """The order in 1/x between the last two points that are due to the steps."""
        above = [i for i, r in enumerate(self.residuals) if r > FLOOR][-2:]
        (x0, x1), (r0, r1) = np.log([self.x[i] for i in above]), np.log([self.residuals[i] for i in above])
        return float((r0 - r1) / (x1 - x0))


def study(*, vertices: int, degree: int, steps: int, seeds: int) -> Section:
    """The cited methods and this library's on the same metrics.

    Parameters
    ----------
    vertices : int
        Of the meshes; at least two for a harmonic.
    degree : int
        Of the harmonics, at least 4.
    steps : int
        Of the embedding flow.
    seeds : int
        Random starts of the harmonics for each metric and size of bumps.
    """
    subjects = paper_subjects()
    runs = compare(subjects, vertices=vertices, degree=degree, steps=steps)
    problems = [run.problem for run in runs if run.method == TRUTH]
    by_degree = degree_curves(problems, range(2, degree + 1, 2))
    by_steps = step_curves(problems[2])
    bent = flow_curves((problems[3], Problem.of(saddled(), vertices)), (degree // 2, degree), steps)
    stuck = [[searches(subject, SEARCHED, bumps, seeds) for bumps in SIZES] for subject in subjects]
    return Section.of(
        "baselines",
        figures={
            "baselines-convergence": _convergence(by_degree, by_steps),
            "baselines-surfaces": _row([run for run in runs if run.problem is problems[0]]),
        },
        tables=(
            run_table(
                f"The methods on four metrics: harmonics of degree {degree}, {steps} steps of order 4 of the "
                "embedding flow",
                runs,
            ),
            Table(
                f"Harmonics of degree {SEARCHED} from random starts: how many ended with more than "
                f"{WORSE:g} times the strain that the round sphere leads to",
                ("metric", *(f"bumps of {size:g} radii" for size in SIZES)),
                tuple(
                    (subject.name, *(f"{count} of {seeds}" for count in counts))
                    for subject, counts in zip(subjects, stuck, strict=True)
                ),
            ),
            Table(
                "The embedding flow where K < 0 in places, which the published method excludes: the residual "
                "by the degree of the harmonics",
                ("metric", *(f"degree {n}" for n in bent[0].x)),
                tuple((curve.label, *(f"{r:.1e}" for r in curve.residuals)) for curve in bent),
            ),
        ),
        numbers={
            "runs": [run.numbers for run in runs],
            "residual_by_degree": {curve.label: list(curve.residuals) for curve in by_degree},
            "flow_residual_where_K_is_negative": {curve.label: list(curve.residuals) for curve in bent},
            "flow_orders": {curve.label: curve.order for curve in by_steps},
            "harmonics_stuck": {
                subject.name: counts for subject, counts in zip(subjects, stuck, strict=True)
            },
        },
        vertices=vertices,
        rough=ROUGH,
        degree=degree,
        bumps=BUMPS,
        flow_degree=FLOWED.degree,
        subjects=subjects,
        starts=len(subjects) * len(SIZES) * seeds,
        searched=SEARCHED,
        worse=WORSE,
        **_said(runs, by_degree, bent, int(np.sum(stuck))),
    )


def degree_curves(problems: Sequence[Problem], degrees: Sequence[int]) -> list[Curve]:
    """The residuals of harmonics that are fitted from the round sphere."""
    return [
        Curve(p.subject.name, degrees, [_residual(p, fitted(p.subject, degree)) for degree in degrees])
        for p in problems
    ]


def flow_curves(problems: Sequence[Problem], degrees: Sequence[int], steps: int) -> list[Curve]:
    """The residuals of the embedding flow, of order 4, by degree."""
    curves = []
    for problem in problems:
        metric = problem.subject.metric
        starts = [uniformized(metric, Harmonics(degree, degree)) for degree in degrees]
        residuals = [_residual(problem, embedding_flow(metric, start, steps)) for start in starts]
        curves.append(Curve(problem.subject.name, degrees, residuals))
    return curves


def step_curves(problem: Problem) -> list[Curve]:
    """The residuals of the embedding flow of a surface of revolution, one curve for each order."""
    metric = problem.subject.metric
    start, counts = uniformized(metric, FLOWED), [2**k for k in range(HALVINGS)]
    return [
        Curve(
            f"order {order}",
            counts,
            [_residual(problem, embedding_flow(metric, start, n, order)) for n in counts],
        )
        for order in STAGES
    ]


def _residual(problem: Problem, found: HarmonicMap) -> float:
    return problem.realized(found.points(problem.directions)).residual


def _convergence(by_degree: Sequence[Curve], by_steps: Sequence[Curve]) -> Figure:
    figure = plots.blank(3.4)
    left, right = figure.subplots(1, 2, sharey=True)
    for curve, style in plots.styled(by_degree):
        left.semilogy(curve.x, curve.residuals, markersize=4, label=curve.label, **style)
    for curve, style in plots.styled(by_steps):
        label = f"{curve.label}: measured {curve.order:.2f}"
        right.loglog(curve.x, curve.residuals, markersize=4, label=label, **style)
    plots.dress(
        left, "degree of the harmonics", "largest length error / mean edge", "Harmonics, from the sphere"
    )
    plots.dress(right, "steps of the flow", "", "Embedding flow, Kerr horizon")
    left.set_xticks(by_degree[0].x)
    right.set_xticks(by_steps[0].x, [str(n) for n in by_steps[0].x])
    right.minorticks_off()
    for axes in (left, right):
        plots.legend(axes, loc="lower left")
    return figure


def _row(runs: Sequence[Run]) -> Figure:
    chosen = {run.method: run.surface for run in runs}
    truth = chosen[TRUTH]
    row = [
        Panel(
            aligned(chosen[method].vertices, truth.vertices),
            truth.faces,
            chosen[method].mean_curvature,
            title,
        )
        for method, title in SHOWN.items()
    ]
    return panels(row, label="mean curvature H")


def _said(
    runs: Sequence[Run], by_degree: Sequence[Curve], bent: Sequence[Curve], stuck: int
) -> dict[str, Any]:
    """What the comparisons with the paper say."""
    notes = [run.note for run in runs if run.method.startswith("wire frame")]
    ours = {name: [run for run in runs if run.method == f"isoembed, {name}"] for name in ("paper", "aim")}
    missed = [
        f"{run.problem.subject.name}: {run.note}, {run.problem.distance(run.surface):.0e} of the diameter "
        "from the true one"
        for run in ours["paper"]
        if run.note != FOUND
    ]
    return {
        "wire_runs": len(notes),
        "wire_found": notes.count(FOUND),
        "wire_others": notes.count(OTHER),
        "wire_missed": notes.count(SHORT),
        "stuck": stuck,
        "by_degree": "; ".join(
            f"{curve.label}: {curve.residuals[0]:.0e} at degree {curve.x[0]}, {curve.residuals[-1]:.0e} at "
            f"{curve.x[-1]}"
            for curve in by_degree
        ),
        "bent": "; ".join(
            f"{curve.label}: residual "
            + ", ".join(f"{r:.1e} at degree {n}" for n, r in zip(curve.x, curve.residuals, strict=True))
            for curve in bent
        ),
        "ours": "; ".join(
            f"{name}: {sum(run.note == FOUND for run in found)} of {len(found)} true surfaces, residuals "
            f"up to {max(run.surface.residual for run in found):.0e}"
            for name, found in ours.items()
        ),
        "missed": f"{'; '.join(missed)}." if missed else "",
    }
