"""The cited methods and this library on the same metrics: what each finds, and what it costs."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

from isoembed import Embedding, InvalidParameter
from isoembed.smooth import Harmonics
from reproduction.arrays import Floats
from reproduction.baselines.embedding_flow import embedding_flow
from reproduction.baselines.isometry import IsometrySystem
from reproduction.baselines.spherical_harmonics import HarmonicMap, fit_harmonics, projected, sphere
from reproduction.baselines.subjects import ARRIVED, Problem, Subject
from reproduction.baselines.uniformization import RoundSphere, uniformized
from reproduction.baselines.wire_frame import TOLERANCE, sphere_layout, wire_frame
from reproduction.bodies import attempted
from reproduction.section import Table

ROUGH = 0.3  # mean edge lengths, of the wire frame's second start
BUMPS = 0.3  # radii, of the harmonics' second start
VERTICES = 2  # for each harmonic, at least
WORSE = 2.0  # ratio to the least strain beyond which the degree does not explain it
RESOLVED = 1e-5  # strain whose square a minimizer can hardly tell from zero
TRUTH = "(true surface)"
FOUND, OTHER, SHORT = "the true surface", "exact lengths, another surface", "stopped short of the lengths"
COLUMNS = {
    "metric": "{metric}",
    "method": "{method}",
    "residual": "{residual:.1e}",
    "distance": "{distance:.1e}",
    "inverted": "{inverted}",
    "concave edges": "{concave_edges}",
    "seconds": "{clock}",
    "note": "{note}",
}

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Run:
    """One method on one problem.

    Attributes
    ----------
    problem : Problem
    method : str
    surface : Embedding
        On the triangles of the problem: smooth maps are evaluated at the vertices.
    seconds : float
    note : str
        How it ended.
    """

    problem: Problem
    method: str
    surface: Embedding
    seconds: float
    note: str

    @property
    def numbers(self) -> dict[str, Any]:
        """All that is said about it; inverted vertices include partially inverted ones."""
        surface = self.surface
        return {
            "metric": self.problem.subject.name,
            "method": self.method,
            "residual": surface.residual,
            "distance": self.problem.distance(surface),
            "inverted": int(
                (surface.surface.inverted_vertices | surface.surface.partially_inverted_vertices).sum()
            ),
            "concave_edges": int(surface.surface.concave_edges.sum()),
            "seconds": self.seconds,
            "note": self.note,
        }


def run_table(caption: str, runs: Sequence[Run]) -> Table:
    """A row for each run."""
    clocks = [f"{run.seconds:.2f}" if run.seconds else "" for run in runs]
    return Table.of(
        caption,
        COLUMNS.items(),
        [{**run.numbers, "clock": clock} for run, clock in zip(runs, clocks, strict=True)],
    )


def compare(subjects: Sequence[Subject], *, vertices: int, degree: int, steps: int) -> tuple[Run, ...]:
    """Runs of the three cited methods and of this library's on the same triangles.

    Parameters
    ----------
    subjects : sequence of Subject
    vertices : int
        Of the mesh of each.
    degree : int
        Of the harmonics, at least 1.
    steps : int
        Of the embedding flow, at least 1.

    Returns
    -------
    tuple of Run
        Nine for each subject: the true vertices themselves come first.

    Raises
    ------
    InvalidParameter
        The vertices are too few to fit so many harmonics to.
    """
    harmonics = Harmonics(degree, degree)
    if vertices < VERTICES * harmonics.size:
        raise InvalidParameter(
            f"{vertices} vertices are too few for the {harmonics.size} harmonics of degree {degree}:"
            f" {VERTICES * harmonics.size} are needed"
        )
    return tuple(
        run for subject in subjects for run in _runs(Problem.of(subject, vertices), harmonics, steps)
    )


def fit(subject: Subject, degree: int, bumps: float = 0.0, seed: int = 0) -> HarmonicMap:
    """The harmonics that are fitted from the round sphere, or from one with random bumps."""
    harmonics = Harmonics(degree, degree)
    return fit_harmonics(subject.metric, harmonics, sphere(subject.metric, harmonics, bumps, seed))


fitted = cache(fit)


def searches(subject: Subject, degree: int, bumps: float, seeds: int) -> int:
    """Of so many spheres with random bumps, how many lead harmonics to a worse map than the round one does.

    Worse means more than `WORSE` times the strain.
    """
    most = WORSE * fitted(subject, degree).strain
    return sum(fitted(subject, degree, bumps, seed).strain > most for seed in range(seeds))


def _runs(problem: Problem, harmonics: Harmonics, steps: int) -> list[Run]:
    subject, u = problem.subject, problem.directions
    runs = [Run(problem, TRUTH, problem.realized(problem.vertices), 0.0, "")]
    for noise, name in ((0.0, "from a sphere"), (ROUGH, "from a rough sphere")):
        found, seconds = _timed(_wire, problem, noise)
        runs.append(Run(problem, f"wire frame, {name}", found, seconds, _length_note(problem, found)))

    starts = {"from a sphere": 0.0, "from a bumpy sphere": BUMPS}
    maps = {name: _timed(fit, subject, harmonics.degree, bumps) for name, bumps in starts.items()}
    from_truth = fit_harmonics(subject.metric, harmonics, projected(problem.vertices, u, harmonics))
    least = min(from_truth.strain, *(one.strain for one, _ in maps.values()))
    for name, (one, seconds) in maps.items():
        surface = problem.realized(one.points(u))
        runs.append(Run(problem, f"harmonics, {name}", surface, seconds, _harmonic_note(one, least)))

    (start, flowed), seconds = _timed(_flow, subject, harmonics, steps)
    notes = ["the curvature did not become uniform"] * (not start.settled)
    notes += ["K < 0 in places, where the published method does not apply"] * (start.least_curvature < 0.0)
    surface = problem.realized(flowed.points(u))
    runs.append(Run(problem, "embedding flow", surface, seconds, "; ".join(notes)))

    for method in ("paper", "aim"):
        found, seconds = _timed(attempted, problem.metric, method, TOLERANCE)
        runs.append(Run(problem, f"isoembed, {method}", found, seconds, _length_note(problem, found)))

    # What `embed_smooth` does at one degree: it fits harmonics to the polyhedron and goes on from there.
    guess, more = _timed(projected, found.vertices, u, harmonics)
    C, still_more = _timed(_fitted, subject, harmonics, guess)
    surface = problem.realized(harmonics.values(u) @ C)
    runs.append(Run(problem, "isoembed, aim and harmonics", surface, seconds + more + still_more, ""))
    return runs


def _timed(make: Callable[..., T], *arguments: Any) -> tuple[T, float]:
    """What a function makes, and the seconds that it takes."""
    begin = time.perf_counter()
    return make(*arguments), time.perf_counter() - begin


def _wire(problem: Problem, noise: float) -> Embedding:
    return wire_frame(problem.metric, sphere_layout(problem.metric, noise))


def _fitted(subject: Subject, harmonics: Harmonics, guess: Floats) -> Floats:
    return IsometrySystem.of(subject.metric, harmonics).fitted(guess)


def _flow(subject: Subject, harmonics: Harmonics, steps: int) -> tuple[RoundSphere, HarmonicMap]:
    start = uniformized(subject.metric, harmonics)
    return start, embedding_flow(subject.metric, start, steps)


def _length_note(problem: Problem, found: Embedding) -> str:
    """What a method that looks for exact lengths has found."""
    if not found.converged:
        return SHORT
    return FOUND if problem.distance(found) <= ARRIVED else OTHER


def _harmonic_note(one: HarmonicMap, least: float) -> str:
    ratio = one.strain / least
    note = f"{one.iterations} iterations"
    if ratio <= WORSE or one.strain <= RESOLVED:
        return note
    end = "a local minimum" if one.settled else "not settled"
    return f"{note}; {end}, {ratio:.3g} times the least strain"
