"""The search for all realizations of lengths near a surface.

From one realization to the next: the leads from each (`realization_leads`) are followed by Newton's method.
What is found is searched from in turn, breadth first and smoothest first: where n vertices can be pushed in
one by one there are 2^n realizations, too many for all of them, and the surface that is meant is among the
smooth ones.  So after each search the smoothest is made smoother still, as far as leads do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from isoembed.aim.anneal import Annealed, anneal
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_realizations import predicted_motions, softest_motions
from isoembed.aim.realization_leads import Lead, leads
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.surface.alignment import distance
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smoothness import fine_roughness
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class SearchThresholds:
    """Thresholds of the search for all realizations."""

    softest: int = threshold(2, "count", "Motions that may hide others, set apart, or lead across a fold.")
    smoother: int = threshold(4, "count", "Moves to smoother realizations at most after each search.")
    probe: int = threshold(3, "count", "Newton steps that tell whether an end is promising.")
    promising: float = threshold(0.1, "relative", "Residual after them, at most; so after the next.")
    returns: float = threshold(1e-4, "mean edge lengths", "As near, it leads to a realization that is known.")
    steps: int = threshold(4, "count", "Further Newton steps at most.")
    same: float = threshold(1e-7, "mean edge lengths", "Realizations as near as this are one.")
    realized: float = threshold(1e-11, "mean edge lengths", "Largest residual of a realization.")


SEARCH = SearchThresholds()


@dataclass(eq=False)
class RealizationSearch:
    """The search for realizations near given vertices, and what it has found.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        Where the search is about; the lengths may be missed there.
    lengths : ndarray, shape (E,)
        Of mean 1 or so.
    recorder : StageRecorder
    motions : int
        How many motions are taken together at most.
    distance : float
        How far from the given one a vertex of a realization may be, in mean edge lengths.

    Attributes
    ----------
    found : list of ndarray, shape (V, 3)
        The realizations.
    searched : list of bool
        Whether each was searched from.
    flexible : int
        How many could not be searched from, because there J is singular.
    incomplete : int
        How many systems of quadratic equations were solved incompletely.
    """

    system: LengthSystem
    vertices: Floats
    lengths: Floats
    recorder: StageRecorder
    motions: int
    distance: float
    found: list[Floats] = field(default_factory=list)
    searched: list[bool] = field(default_factory=list)
    flexible: int = 0
    incomplete: int = 0
    _roughness: list[float] = field(default_factory=list)
    _moves: list[int] = field(default_factory=list)
    _leads: dict[int, deque[Lead]] = field(default_factory=dict)  # not yet followed, by the realization
    _attempts: dict[float, Floats] = field(default_factory=dict)  # by the residual

    def steps(self, surfaces: int) -> Iterator[None]:
        """Search from the given vertices, then from realizations: with the given one, so many at most.

        These are in turn the smoothest of all, and the smoothest of those that the fewest moves from
        realization to realization lead to.  It stops after each, and after each move to a smoother one,
        with `found` as it is then.  As long as nothing is found it goes on from the attempts that miss the
        lengths by least.
        """
        self.polish(self.vertices)
        self.searched[:] = [True for _ in self.found]
        given = len(self.found)
        for hidden in (0, SEARCH.softest):
            self._follow(self._leads_from(self.vertices, hidden), given)
            yield
        for step in range(surfaces - given):
            yield from self._smoothed()
            left = [i for i, searched in enumerate(self.searched) if not searched]
            if left:
                i = min(left, key=lambda i: (self._moves[i] if step % 2 else 0, self._roughness[i]))
                self.searched[i] = True
                self._search(self.found[i], self._opened(i), self._moves[i] + 1)
            elif not self.found and self._attempts:
                attempt = self._attempts.pop(min(self._attempts))
                self._search(attempt, self._leads_from(attempt, 0), 0)
            else:
                return
            yield

    def polish(self, vertices: Floats, moves: int = 0) -> None:
        """Add the realizations that Newton's method leads to, if they are new and near enough."""
        start, realized = self._residual(vertices), SEARCH.realized * self._unit
        probed = self._annealed(vertices, SEARCH.probe)
        good = probed.residual <= max(SEARCH.promising * start, realized)
        if good and self._is_known(probed.vertices, SEARCH.returns):
            return
        found = self._annealed(probed.vertices, SEARCH.steps) if good else probed
        if found.residual <= realized:
            self._add(found.vertices, moves)
            return
        if good and found.residual <= SEARCH.promising * probed.residual:
            self._add_close(found.vertices, moves)
        if not self.found and found.vertices is not vertices:
            self._attempts[found.residual] = found.vertices

    @property
    def _unit(self) -> float:
        return float(self.lengths.mean())

    def _smoothed(self) -> Iterator[None]:
        """From the smoothest realization, follow what leads to smoother ones until there is one."""
        for _ in range(min(SEARCH.smoother, len(self.found))):
            best = min(self._roughness)
            i = self._roughness.index(best)
            if self.searched[i]:
                return
            left = self._opened(i)
            while left and left[0].roughness < best == min(self._roughness):
                self.polish(left.popleft().vertices, self._moves[i] + 1)
            if best == min(self._roughness):
                return
            yield

    def _search(self, vertices: Floats, left: deque[Lead], moves: int) -> None:
        """Follow leads from vertices; if nothing new is found, others, with the softest motions set apart."""
        known = len(self.found)
        self._follow(left, moves)
        if len(self.found) == known:
            self._follow(self._leads_from(vertices, SEARCH.softest), moves)

    def _opened(self, i: int) -> deque[Lead]:
        """The leads from a realization that were not followed yet."""
        if i not in self._leads:
            self._leads[i] = self._leads_from(self.found[i], 0)
        return self._leads[i]

    def _leads_from(self, vertices: Floats, hidden: int) -> deque[Lead]:
        """Leads from vertices; as long as nothing is found, the softest motions join all others."""
        expansion = LengthExpansion(self.system, vertices, self.lengths)
        always = hidden if self.found else SEARCH.softest
        self.recorder.factorizations += 2
        try:
            found = leads(expansion, self.motions, self.distance, hidden, always)
        except SingularMatrix:
            self.flexible += not hidden
            return deque()
        self.incomplete += found.incomplete
        return deque(found.leads)

    def _follow(self, left: deque[Lead], moves: int) -> None:
        while left:
            self.polish(left.popleft().vertices, moves)

    def _add_close(self, vertices: Floats, moves: int) -> None:
        """Add the two realizations near a fold, where they are close and Newton's method is slow."""
        expansion = LengthExpansion(self.system, vertices, self.lengths)
        self.recorder.factorizations += 1
        softest = softest_motions(expansion, SEARCH.softest)
        for motion in predicted_motions(expansion, softest, self.distance).motions[:2]:
            found = self._annealed(vertices + motion, SEARCH.steps)
            if found.residual <= SEARCH.realized * self._unit:
                self._add(found.vertices, moves)

    def _add(self, x: Floats, moves: int) -> None:
        """Add a realization, if it is new and near enough."""
        if distance(x, self.vertices, self.system.space) > self.distance * self._unit:
            return
        if not self._is_known(x, SEARCH.same):
            self.found.append(x)
            self.searched.append(False)
            self._moves.append(moves)
            self._roughness.append(fine_roughness(self.system.triangulation, x))

    def _is_known(self, vertices: Floats, near: float) -> bool:
        space = self.system.space
        return any(distance(vertices, other, space) <= near * self._unit for other in self.found)

    def _annealed(self, vertices: Floats, steps: int) -> Annealed:
        return anneal(self.system, vertices, self.lengths, self.recorder, max_iterations=steps)

    def _residual(self, vertices: Floats) -> float:
        errors = length_residuals(self.system.triangulation, vertices, self.lengths, self.system.space)
        return float(np.abs(errors).max())
