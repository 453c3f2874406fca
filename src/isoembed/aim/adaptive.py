"""The default method: AIM from a conformal polyhedron inscribed in a sphere, in steps of its own choice.

The paper's three steps with their weak points replaced.  Uniformization and layout are one: the discretely
conformal layout on the sphere *is* an embedded metric, so nothing has to be annealed.  The pull-back follows
``log l`` linearly (linear in u, as the paper's path), predicts by the polynomial through the last surfaces,
corrects by Newton's method and halves its step where that fails; where even short steps fail, steps damped in
a bending metric take over.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.anneal import Annealed, anneal, anneal_damped
from isoembed.aim.conformal_sphere import conformal_sphere
from isoembed.aim.convexity import crumpled_vertices, pop_and_anneal
from isoembed.aim.pullback import extrapolated
from isoembed.linalg import dissect
from isoembed.metric.curvature import area
from isoembed.metric.delaunay import delaunay
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.stages import Log, Tally
from isoembed.surface.embedding import Embedding
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem, VertexSystem, umbrella

Floats = NDArray[np.float64]

ON_THE_WAY = 1e-6  # residual of the surfaces on the path
POLISHED = 1e-13  # residual asked of the last Newton steps, whatever the tolerance: they are quadratic
PATIENCE = 6  # Newton steps before a step along the path is halved


@dataclass(frozen=True)
class Aim:
    """The adaptive method.

    Parameters
    ----------
    first_step : float
        Length in t of the first step from the uniform metric at t = 1 toward the given one at t = 0.
    smallest_step : float
        Where a step shorter than this fails, damped steps take over.
    damped_iterations : int
        At most so many damped steps at one t.
    """

    first_step: float = 1 / 3
    smallest_step: float = 1 / 24
    damped_iterations: int = 60

    name: str = field(default="aim", init=False, repr=False)

    def __post_init__(self) -> None:
        if not 0 < self.first_step <= 1:
            raise ValueError(f"first_step is {self.first_step}, not in (0, 1]")
        if not 0 < self.smallest_step <= self.first_step:
            raise ValueError(f"smallest_step is {self.smallest_step}, not in (0, first_step]")
        if self.damped_iterations < 0:
            raise ValueError(f"damped_iterations is {self.damped_iterations}, not a number of iterations")

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> Embedding:
        """Embed the metric; the answer may miss the tolerance, and says so.

        Parameters
        ----------
        metric : PolyhedralMetric
        tolerance : float
            Largest residual to count as converged.
        log : Log
            Records the stages.

        Returns
        -------
        Embedding
        """
        normalized = metric.normalized
        with log.stage("uniformize") as tally:
            vertices = inscribed(normalized, tally)
        with log.stage("pull back") as tally:
            path = _Path(normalized, vertices)
            vertices = path.follow(self, tally)
        with log.stage("polish") as tally:
            vertices = path.polish(vertices, min(tolerance, POLISHED), self.damped_iterations, tally)
        return Embedding(
            metric, vertices * metric.mean_length, method=self.name, tolerance=tolerance, stages=log.stages
        )


def inscribed(metric: PolyhedralMetric, tally: Tally) -> Floats:
    """The conformal layout on the sphere whose polyhedron has the metric's area, shape (V, 3).

    Parameters
    ----------
    metric : PolyhedralMetric
    tally : Tally
    """
    x = outward(metric.faces, conformal_sphere(delaunay(metric), tally).points)
    return x * np.sqrt(area(metric) / area(PolyhedralMetric.from_mesh(x, metric.faces)))


class _Path:
    """The metrics ``l(t) = l(0)^{1-t} l(1)^t`` from an embedded one at t = 1 to the given one at t = 0."""

    def __init__(self, metric: PolyhedralMetric, start: Floats) -> None:
        self.triangulation = metric.triangulation
        self._given = metric.lengths
        a, b = self.triangulation.edges.T
        self._ratio = np.linalg.norm(start[a] - start[b], axis=1) / metric.lengths
        self._start = start
        dissection = dissect(self.triangulation.adjacency)
        self._newton = LengthSystem(self.triangulation, dissection)
        self._dissection = dissection
        self._damped: VertexSystem | None = None

    def lengths(self, t: float) -> Floats:
        return self._given * self._ratio**t

    def follow(self, method: Aim, tally: Tally) -> Floats:
        """Go from t = 1 to t = 0."""
        known = [(1.0, self._start)]
        t, dt = 1.0, method.first_step
        while t > 0:
            goal = t - dt if t - dt > dt / 4 else 0.0
            guess = extrapolated(known[-3:], goal)
            before = tally.iterations
            annealed = self._step(guess, goal, tally)
            if not annealed.converged:
                if dt / 2 >= method.smallest_step:
                    dt /= 2
                    continue
                annealed = self._rescue(known[-1][1], goal, method.damped_iterations, tally)
            annealed = pop_and_anneal(self.triangulation, annealed, partial(self._step, t=goal, tally=tally))
            inverted, partially = crumpled_vertices(self.triangulation, annealed.vertices)
            t = goal
            tally.show(
                t=t,
                residual=annealed.residual,
                inverted=int(inverted.sum()),
                partially_inverted=int(partially.sum()),
            )
            known.append((t, annealed.vertices))
            if tally.iterations - before <= PATIENCE // 2:
                dt = min(2 * dt, method.first_step)
        return known[-1][1]

    def polish(self, vertices: Floats, tolerance: float, damped_iterations: int, tally: Tally) -> Floats:
        """Newton's method to the rounding floor, damped where it fails."""
        annealed = anneal(self._newton, vertices, self._given, tally, residual_tolerance=tolerance)
        if annealed.residual > ON_THE_WAY:
            annealed = self._rescue(vertices, 0.0, damped_iterations, tally)
            annealed = anneal(
                self._newton, annealed.vertices, self._given, tally, residual_tolerance=tolerance
            )
        return annealed.vertices

    def _step(self, guess: Floats, t: float, tally: Tally) -> Annealed:
        return anneal(
            self._newton,
            guess,
            self.lengths(t),
            tally,
            residual_tolerance=ON_THE_WAY,
            max_iterations=PATIENCE,
        )

    def _rescue(self, vertices: Floats, t: float, iterations: int, tally: Tally) -> Annealed:
        if self._damped is None:
            L = umbrella(self.triangulation)
            self._damped = VertexSystem(self.triangulation, (L.T @ L).tocsr(), self._dissection)
        return anneal_damped(
            self._damped,
            vertices,
            self.lengths(t),
            tally,
            residual_tolerance=ON_THE_WAY,
            max_iterations=iterations,
        )
