"""The default method: AIM from a conformal polyhedron inscribed in a sphere, in steps of its own choice.

The paper's three steps with their weak points replaced.  Uniformization and layout are one: the discretely
conformal layout on the sphere *is* an embedded metric, so nothing has to be annealed.  The pull-back follows
``log l`` linearly (linear in u, as the paper's path), predicts by the polynomial through the last surfaces,
corrects by Newton's method and halves its step where that fails; where even short steps fail, the pull-back
is begun anew, guided by a vanishing bending energy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.anneal import Annealed, anneal
from isoembed.aim.bending import bending_pull_back
from isoembed.aim.conformal_sphere import conformal_sphere
from isoembed.aim.convexity import crumpled_vertices, pop_and_anneal
from isoembed.aim.pullback import extrapolated
from isoembed.errors import InvalidParameter
from isoembed.linalg import SingularMatrix, chosen_backend, dissect
from isoembed.metric.curvature import area, negative_deficits
from isoembed.metric.delaunay import delaunay
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.stages import Log, Tally
from isoembed.surface.convexity import umbrella_heights
from isoembed.surface.embedding import Embedding
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem, length_residuals

Floats = NDArray[np.float64]

ON_THE_WAY = 1e-4  # residual of the surfaces on the path
GUIDED = 1e-7  # residual at which Newton's method takes over from the guided pull-back
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
        Where a step that cannot be halved any more fails, the guided pull-back takes over.
    largest_change : float
        A step is accepted while no vertex's height above its neighbors changes from its prediction by more
        than this, in units of the root mean square height.
    backend : {"superlu", "cholmod", "pardiso"}, optional
        Who factors the matrices; by default the fastest that is installed.
    """

    first_step: float = 1 / 8
    smallest_step: float = 1 / 48
    largest_change: float = 0.5
    backend: str | None = None

    name: str = field(default="aim", init=False, repr=False)

    def __post_init__(self) -> None:
        if not 0 < self.first_step <= 1:
            raise InvalidParameter(f"first_step is {self.first_step}, not in (0, 1]")
        if not 0 < self.smallest_step <= self.first_step:
            raise InvalidParameter(f"smallest_step is {self.smallest_step}, not in (0, first_step]")
        if not self.largest_change > 0:
            raise InvalidParameter(f"largest_change is {self.largest_change}, not positive")
        chosen_backend(self.backend)

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
            vertices = inscribed(normalized, tally, self.backend)
        with log.stage("pull back") as tally:
            path = _Path(normalized, vertices, self.backend)
            vertices, lost = path.follow(self, tally)
            if lost is None and not negative_deficits(metric).any():
                # A convex metric has a convex realization: one that is inside out at a vertex is not it.
                lost = 0.0 if crumpled_vertices(metric.triangulation, vertices)[0].any() else None
        if lost is not None:
            with log.stage("guided pull back") as tally:
                vertices = path.guided(tally)
        with log.stage("polish") as tally:
            vertices = path.polish(vertices, min(tolerance, POLISHED), tally)
        embedding = Embedding(
            metric, vertices * metric.unit, method=self.name, tolerance=tolerance, stages=log.stages
        )
        if embedding.converged or lost is None:
            return embedding
        return embedding.with_message(
            f"{embedding.message}; Newton's method lost the surface at t = {lost:.3g} "
            "(1 is the uniform metric, 0 the given one), and guided by bending the pull-back did not reach it"
        )


def inscribed(metric: PolyhedralMetric, tally: Tally, backend: str | None = None) -> Floats:
    """The conformal layout on the sphere whose polyhedron has the metric's area, shape (V, 3).

    Parameters
    ----------
    metric : PolyhedralMetric
    tally : Tally
    backend : str, optional
        As in `isoembed.linalg.analyze`.
    """
    x = outward(metric.faces, conformal_sphere(delaunay(metric), tally, backend).points)
    return x * np.sqrt(area(metric) / area(PolyhedralMetric.from_mesh(x, metric.faces)))


class _Path:
    """The metrics ``l(t) = l(0)^{1-t} l(1)^t`` from an embedded one at t = 1 to the given one at t = 0."""

    def __init__(self, metric: PolyhedralMetric, start: Floats, backend: str | None) -> None:
        self.triangulation = metric.triangulation
        self._metric = metric
        a, b = self.triangulation.edges.T
        self._ratio = np.linalg.norm(start[a] - start[b], axis=1) / metric.lengths
        self._start = start
        dissection = dissect(self.triangulation.adjacency)
        self._newton = LengthSystem(self.triangulation, dissection, backend)
        self._dissection, self._backend = dissection, backend

    def lengths(self, t: float) -> Floats:
        return self._metric.lengths * self._ratio**t

    def follow(self, method: Aim, tally: Tally) -> tuple[Floats, float | None]:
        """Go from t = 1 to t = 0, or to the t at which the surface is lost, which is returned too."""
        known = [(1.0, self._start)]
        t, dt = 1.0, method.first_step
        while t > 0:
            goal = t - dt if t - dt > dt / 4 else 0.0
            guess = self._predicted(known[-3:], goal, tally)
            annealed = self._corrected(guess, goal, tally)
            change = self._change(guess, annealed.vertices)
            if not (annealed.converged and change < method.largest_change):
                if dt / 2 >= method.smallest_step:
                    dt /= 2
                    continue
                return known[-1][1], goal
            t = goal
            annealed = pop_and_anneal(
                self.triangulation, annealed, partial(self._corrected, t=goal, tally=tally)
            )
            known.append((t, annealed.vertices))
            inverted, partially = crumpled_vertices(self.triangulation, annealed.vertices)
            tally.show(
                t=t,
                residual=annealed.residual,
                inverted=int(inverted.sum()),
                partially_inverted=int(partially.sum()),
            )
            # The predictor's error grows as the cube of the step.
            growth = np.cbrt(method.largest_change / (2 * max(change, np.finfo(np.float64).tiny)))
            dt *= float(np.clip(growth, 0.5, 2.0))
        return known[-1][1], None

    def guided(self, tally: Tally) -> Floats:
        """Go from t = 1 to t = 0 once more, guided by bending."""
        return bending_pull_back(
            self._metric,
            self._start,
            self.lengths,
            tally,
            residual_tolerance=GUIDED,
            dissection=self._dissection,
            backend=self._backend,
        )

    def polish(self, vertices: Floats, tolerance: float, tally: Tally) -> Floats:
        """Newton's method to the rounding floor."""
        return anneal(
            self._newton, vertices, self._metric.lengths, tally, residual_tolerance=tolerance
        ).vertices

    def _predicted(self, known: list[tuple[float, Floats]], t: float, tally: Tally) -> Floats:
        """The polynomial through the surfaces before; from one alone, the tangent."""
        if len(known) > 1:
            return extrapolated(known, t)
        x = known[0][1]
        lengths = self.lengths(t)
        tally.factorizations += 1
        try:
            return x - self._newton.step(x, lengths, length_residuals(self.triangulation, x, lengths))
        except SingularMatrix:
            return x

    def _corrected(self, guess: Floats, t: float, tally: Tally) -> Annealed:
        return anneal(
            self._newton,
            guess,
            self.lengths(t),
            tally,
            residual_tolerance=ON_THE_WAY,
            max_iterations=PATIENCE,
        )

    def _change(self, guess: Floats, vertices: Floats) -> float:
        """The largest change of a vertex's height above its neighbors, over the root mean square height.

        Newton's method can cross over to a neighboring realization, with some vertices turned inside out,
        that has the same lengths.  Then a height changes by more than the predictor's error explains.
        """
        before = umbrella_heights(self.triangulation, guess)
        after = umbrella_heights(self.triangulation, vertices)
        return float(np.abs(after - before).max() / np.sqrt(np.mean(after**2)))
