"""Breadth-first search for realizations near a surface.

Newton's method is started from the `start_points` about each realization.  The intended surface is usually
among the smooth ones.  Therefore the smoothest realization is improved first, as far as possible: each start
point that predicts a smoother one is tried directly, then relaxed with a smoothness penalty that is released.
The realizations found are searched from in turn, breadth first and smoothest first: if n vertices can be
pushed in independently there are 2^n realizations, too many to list.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from isoembed.aim.acceptance import REALIZED, identical_within
from isoembed.aim.anneal import Annealed, anneal
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_realizations import predicted_motions, softest_motions
from isoembed.aim.regularized_continuation import release_penalty
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.start_points import StartPoint, start_points
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.alignment import distance
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smoothness import fine_roughness

SOFTEST = 2  # softest motions, which hide others near a fold or lead across it
WEIGHTS = (1e-5, 1e-6)  # mean edge lengths^2; initial mu, in turn; larger ones lose the start point
PROMISING = 0.1  # ratio of residuals after and before Newton steps from a promising start
MAX_STEPS = 4  # Newton steps


@dataclass(eq=False)
class RealizationSearch:
    """Search for realizations near given vertices.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        Center of the search, which may miss the lengths.
    recorder : StageRecorder
    motions : int
        Largest number of motions combined.
    distance : float
        Largest displacement of a vertex from the center, in mean edge lengths.

    Attributes
    ----------
    found : list of ndarray, shape (V, 3)
        Realizations, in the order of discovery.
    searched : list of bool
        Whether each was a center of the search.
    flexible : int
        Number of realizations with singular J, which cannot be centers.
    incomplete : int
        Number of systems of quadratic equations solved incompletely.
    """

    metric: PolyhedralMetric
    system: LengthSystem
    vertices: Floats
    recorder: StageRecorder
    motions: int
    distance: float
    found: list[Floats] = field(default_factory=list)
    searched: list[bool] = field(default_factory=list)
    flexible: int = 0
    incomplete: int = 0
    _roughness: list[float] = field(default_factory=list)
    _spans: list[Floats] = field(default_factory=list)  # of the realizations found
    _moves: list[int] = field(default_factory=list)
    _starts: dict[int, deque[StartPoint]] = field(default_factory=dict)  # remaining ones, by realization
    _attempts: dict[float, Floats] = field(default_factory=dict)  # by residual

    def steps(self, surfaces: int) -> Iterator[None]:
        """Search from a number of realizations or, until one is found, from attempts near the center.

        Centers are alternately the smoothest realization, and the smoothest of those reached by the fewest
        moves between realizations, starting with the given one.  Yields after each center and after each move
        to a smoother realization, with `found` up to date.
        """
        self.polish(self.vertices)
        if not self.found:
            yield from self._attempt(self.vertices)
        for step in range(surfaces):
            if surfaces > 1:
                yield from self._smoothed()
            left = [i for i, searched in enumerate(self.searched) if not searched]
            if left:
                i = min(left, key=lambda i: (self._moves[i] if step % 2 else 0, self._roughness[i]))
                self.searched[i] = True
                yield from self._search(i)
            elif not self.found and self._attempts:
                yield from self._attempt(self._attempts.pop(min(self._attempts)))
            else:
                return

    def polish(self, vertices: Floats, moves: int = 0) -> None:
        """Add the realizations that Newton's method reaches, if they are new and near enough."""
        start = self._residual(vertices)
        probed = self._annealed(vertices, 3)  # Newton steps to see whether a start is promising
        good = probed.residual <= max(PROMISING * start, self._realized)
        # Mean edge lengths; within it, the limit is a known realization.
        if good and self._is_known(probed.vertices, 1e-4):
            return
        found = self._annealed(probed.vertices, MAX_STEPS) if good else probed
        if found.residual <= self._realized:
            self._add(found.vertices, moves)
            return
        if good and found.residual <= PROMISING * probed.residual:
            self._add_close(found.vertices, moves)
        if not self.found and found.vertices is not vertices:
            self._attempts[found.residual] = found.vertices

    @cached_property
    def _energy(self) -> RegularizedEnergy:
        return RegularizedEnergy(self.metric, self.vertices, self.recorder.work)

    @property
    def _unit(self) -> float:
        return self.metric.mean_length

    @property
    def _realized(self) -> float:
        """The largest residual of a realization."""
        return REALIZED * self._unit

    def _smoothed(self) -> Iterator[None]:
        """Move from the smoothest realization to smoother ones, as long as start points lead to some."""
        for _ in range(4 if self.found else 0):  # moves after each center
            i = self._roughness.index(self._least_roughness)
            if self.searched[i] or not self._descends(
                self._opened(i), self._roughness[i], self._moves[i] + 1
            ):
                return
            yield

    def _descends(self, left: deque[StartPoint], roughness: float, moves: int) -> bool:
        """Try start points that predict smoother realizations; return whether one is found."""
        relaxed = 0
        while left and left[0].roughness < roughness:
            weights = WEIGHTS if relaxed < 4 else ()  # the four smoothest are relaxed
            if self._is_smoother(left.popleft().vertices, roughness, moves, weights):
                return True
            relaxed += 1
        return False

    def _is_smoother(
        self, vertices: Floats, roughness: float, moves: int, weights: tuple[float, ...]
    ) -> bool:
        """Add realizations near vertices; return whether one is smoother than a given roughness.

        Newton's method alone fails if many vertices have to move together.  The surface is then smoothed with
        each of these weights in turn, and the penalty is released.
        """
        self.polish(vertices, moves)
        for weight in weights:
            if self._least_roughness < roughness:
                break
            energy, mu = self._energy.finer(vertices), weight * self._unit**2
            relaxed, _ = release_penalty(energy, vertices, self.metric.lengths, mu, self.recorder)
            self.polish(relaxed, moves)
        return self._least_roughness < roughness

    @property
    def _least_roughness(self) -> float:
        return min(self._roughness, default=np.inf)

    def _search(self, i: int) -> Iterator[None]:
        """Try all start points about a realization.

        For the given one, and if nothing new is found, also those with the softest motions projected out.
        """
        before, moves = len(self.found), self._moves[i]
        self._follow(self._opened(i), moves + 1)
        yield
        if not moves or len(self.found) == before:
            self._follow(self._starts_from(self.found[i], SOFTEST, SOFTEST), moves + 1)
            yield

    def _attempt(self, vertices: Floats) -> Iterator[None]:
        """Move from a surface that misses the lengths to smoother ones, or try all start points.

        J is nearly singular at the end of an attempt, so the softest motions are projected out first.
        """
        roughness = fine_roughness(self.metric.triangulation, vertices)
        if self._is_smoother(vertices, roughness, 1, WEIGHTS):
            return
        for hidden in (SOFTEST, 0):
            if self._descends(self._starts_from(vertices, hidden), roughness, 1):
                return
            yield
        for hidden in (0, SOFTEST):
            self._follow(self._starts_from(vertices, hidden, SOFTEST), 1)
            yield

    def _opened(self, i: int) -> deque[StartPoint]:
        """The remaining start points about a realization."""
        if i not in self._starts:
            self._starts[i] = self._starts_from(self.found[i], 0)
        return self._starts[i]

    def _starts_from(self, vertices: Floats, hidden: int, always: int = 0) -> deque[StartPoint]:
        """Start points about vertices, with a number of softest motions projected out or always included."""
        expansion = LengthExpansion(self.system, vertices, self.metric.lengths)
        try:
            found = start_points(expansion, self.motions, self.distance, hidden, always)
        except SingularMatrix:
            self.flexible += not (hidden or always)
            return deque()
        self.incomplete += found.incomplete
        return deque(found.points)

    def _follow(self, left: deque[StartPoint], moves: int) -> None:
        while left:
            self.polish(left.popleft().vertices, moves)

    def _add_close(self, vertices: Floats, moves: int) -> None:
        """Add two close realizations near a fold, where Newton's method is slow."""
        expansion = LengthExpansion(self.system, vertices, self.metric.lengths)
        softest = softest_motions(expansion, SOFTEST)
        for motion in predicted_motions(expansion, softest, self.distance).motions[:2]:
            found = self._annealed(vertices + motion, MAX_STEPS)
            if found.residual <= self._realized:
                self._add(found.vertices, moves)

    def _add(self, x: Floats, moves: int) -> None:
        """Add a realization, or its mirror image of positive volume, if it is new and near enough."""
        x = self._outward(x)
        if distance(x, self.vertices, self.system.space) > self.distance * self._unit:
            return
        if not self._is_known(x, identical_within(self._residual(x) / self._unit)):
            self.found.append(x)
            self._spans.append(self._spans_of(x))
            self.searched.append(False)
            self._moves.append(moves)
            self._roughness.append(fine_roughness(self.system.triangulation, x))

    def _is_known(self, vertices: Floats, near: float) -> bool:
        if not self.found:
            return False
        space, vertices = self.system.space, self._outward(vertices)
        # If no vertex is farther than a distance from its other place, no span differs by more than twice it.
        differ = np.abs(np.array(self._spans) - self._spans_of(vertices)).max(axis=1)
        close = np.flatnonzero(differ <= 2 * near * self._unit).tolist()
        return any(distance(vertices, self.found[i], space) <= near * self._unit for i in close)

    def _spans_of(self, vertices: Floats) -> Floats:
        """Distances between vertices far apart in number, shape (V,), which rigid motions preserve."""
        return self.system.space.distances(vertices, np.roll(vertices, len(vertices) // 2, axis=0))

    def _outward(self, vertices: Floats) -> Floats:
        return outward(self.system.triangulation.faces, vertices, self.system.space)

    def _annealed(self, vertices: Floats, steps: int) -> Annealed:
        return anneal(self.system, vertices, self.metric.lengths, self.recorder, max_iterations=steps)

    def _residual(self, vertices: Floats) -> float:
        errors = length_residuals(self.system.triangulation, vertices, self.metric.lengths, self.system.space)
        return float(np.abs(errors).max())
