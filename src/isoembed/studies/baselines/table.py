"""The cited methods and this library on the same metrics: what each finds, and what it costs."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from isoembed.errors import InvalidParameter
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import gauss_newton
from isoembed.studies.baselines.embedding_flow import embedding_flow
from isoembed.studies.baselines.spherical_harmonics import HarmonicMap, fit_harmonics, projected, sphere
from isoembed.studies.baselines.subjects import Problem, Subject
from isoembed.studies.baselines.uniformization import uniformized
from isoembed.studies.baselines.wire_frame import sphere_layout, wire_frame
from isoembed.studies.bodies import attempted
from isoembed.surface import alignment
from isoembed.surface.embedding import Embedding

Floats = NDArray[np.float64]

ROUGH = 0.3  # mean edge lengths, of the wire frame's second start
BUMPS = 0.3  # radii, of the harmonics' second start
TOLERANCE = 1e-10  # mean edge lengths: as a user of `isoembed.embed` has it
ARRIVED = 1e-6  # of the diameter: a surface so near to the true one is that
FOUND = "the true surface"
WORSE = 2.0  # strains over the least one from which on they are not due to the degree
RESOLVED = 1e-5  # strains below this have squares that a minimizer cannot tell apart much longer
DETERMINED = 2  # vertices for a harmonic at least


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
    def distance(self) -> float:
        """Largest distance of a vertex from its place on the true surface, over the diameter of that.

        After the best rigid motion or reflection.
        """
        truth = self.problem.vertices
        found = (self.surface.vertices, self.surface.vertices * [1.0, 1.0, -1.0])
        return min(alignment.distance(x, truth) for x in found) / float(pdist(truth).max())

    @property
    def inverted(self) -> int:
        """Inverted and partially inverted vertices."""
        return int((self.surface.inverted_vertices | self.surface.partially_inverted_vertices).sum())

    @property
    def cells(self) -> tuple[str, ...]:
        """As text, under `HEADER`."""
        return (
            self.problem.subject.name,
            self.method,
            f"{self.surface.residual:.1e}",
            f"{self.distance:.1e}",
            str(self.inverted),
            str(int(self.surface.concave_edges.sum())),
            f"{self.seconds:.2f}" if self.seconds else "",
            self.note,
        )


HEADER = ("metric", "method", "residual", "distance", "inverted", "concave edges", "seconds", "note")


def compare(subjects: Sequence[Subject], *, vertices: int, degree: int, steps: int) -> tuple[Run, ...]:
    """Run the three cited methods and this library's on the same triangles.

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
    if vertices < DETERMINED * harmonics.size:
        raise InvalidParameter(
            f"{vertices} vertices are too few for the {harmonics.size} harmonics of degree {degree}:"
            f" {DETERMINED * harmonics.size} are needed"
        )
    return tuple(
        run for subject in subjects for run in _runs(Problem.of(subject, vertices), harmonics, steps)
    )


def searches(subject: Subject, degree: int, bumps: float, seeds: int) -> int:
    """Of so many spheres with random bumps, how many lead harmonics to a worse map than the round one does.

    Worse means more than `WORSE` times the strain.
    """
    harmonics = Harmonics(degree, degree)
    round_one, *others = (
        fit_harmonics(subject.metric, harmonics, sphere(subject.metric, harmonics, size, seed)).strain
        for size, seed in [(0.0, 0), *((bumps, seed) for seed in range(seeds))]
    )
    return sum(strain > WORSE * round_one for strain in others)


def _runs(problem: Problem, harmonics: Harmonics, steps: int) -> list[Run]:
    metric = problem.subject.metric
    truth = Run(problem, "(true surface)", _on_mesh(problem, problem.vertices), 0.0, "")
    runs = [truth]
    for noise, name in ((0.0, "from a sphere"), (ROUGH, "from a rough sphere")):
        begin = time.perf_counter()
        found = wire_frame(problem.metric, sphere_layout(problem.metric, noise))
        seconds = time.perf_counter() - begin
        runs.append(_noted(Run(problem, f"wire frame, {name}", found, seconds, "")))

    maps = []
    for bumps, name in ((0.0, "from a sphere"), (BUMPS, "from a bumpy sphere")):
        begin = time.perf_counter()
        fitted = fit_harmonics(metric, harmonics, sphere(metric, harmonics, bumps))
        maps.append((f"harmonics, {name}", fitted, time.perf_counter() - begin))
    from_truth = fit_harmonics(metric, harmonics, projected(problem.vertices, problem.directions, harmonics))
    least = min(from_truth.strain, *(fitted.strain for _, fitted, _ in maps))
    for name, fitted, seconds in maps:
        surface = _on_mesh(problem, fitted.points(problem.directions))
        runs.append(Run(problem, name, surface, seconds, _harmonic_note(fitted, least)))

    begin = time.perf_counter()
    start = uniformized(metric, harmonics)
    flowed = embedding_flow(metric, start, steps)
    seconds = time.perf_counter() - begin
    notes = ["the curvature did not become uniform"] * (not start.settled)
    notes += ["K < 0 in places, where the published method does not apply"] * (start.least_curvature < 0.0)
    surface = _on_mesh(problem, flowed.points(problem.directions))
    runs.append(Run(problem, "embedding flow", surface, seconds, "; ".join(notes)))

    for method in ("paper", "aim"):
        begin = time.perf_counter()
        found = attempted(problem.metric, method, TOLERANCE)
        runs.append(_noted(Run(problem, f"isoembed, {method}", found, time.perf_counter() - begin, "")))

    # What `embed_smooth` does at one degree: it fits harmonics to the polyhedron and goes on from there.
    begin = time.perf_counter()
    guess = projected(found.vertices, problem.directions, harmonics)
    C = gauss_newton(metric, harmonics, guess)
    seconds = runs[-1].seconds + time.perf_counter() - begin
    surface = _on_mesh(problem, harmonics.values(problem.directions) @ C)
    runs.append(Run(problem, "isoembed, aim and harmonics", surface, seconds, ""))
    return runs


def _on_mesh(problem: Problem, vertices: Floats) -> Embedding:
    return Embedding(problem.metric, vertices, method="baseline", tolerance=ARRIVED)


def _noted(run: Run) -> Run:
    """The run of a method that looks for exact lengths, with what it found."""
    if not run.surface.converged:
        note = "stopped short of the lengths"
    else:
        note = FOUND if run.distance <= ARRIVED else "exact lengths, another surface"
    return replace(run, note=note)


def _harmonic_note(fitted: HarmonicMap, least: float) -> str:
    ratio = fitted.strain / least
    note = f"{fitted.iterations} iterations"
    if ratio <= WORSE or fitted.strain <= RESOLVED:
        return note
    end = "a local minimum" if fitted.settled else "not settled"
    return f"{note}; {end}, {ratio:.3g} times the least strain"
