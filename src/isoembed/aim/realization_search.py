"""The search for all realizations of lengths near a surface.

From one realization to the next: of each, the motions to where others are predicted one by one
(`nearby_motions`), and all roots of the quadratic equations in several of these together
(`nearby_realizations`), each polished by Newton's method.  What is found is searched from in turn, breadth
first and smoothest first: where n vertices can be pushed in one by one there are 2^n realizations, too many
for all of them, and the surface that is meant is among the smooth ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from isoembed.aim.anneal import Annealed, anneal
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_motions import Motions, nearby_motions
from isoembed.aim.nearby_realizations import predicted_motions, softest_motions
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

    beyond: float = threshold(1.1, "distances", "Motions may be predicted to reach so far.")
    beside: int = threshold(3, "count", "Motions that are joined to each that is not among the nearest.")
    softest: int = threshold(
        2, "count", "Motions that are taken always where the lengths are missed, or nothing is found."
    )
    imaginary: float = threshold(0.3, "relative", "Roots that miss being real by less are tried.")
    defect: float = threshold(
        0.7, "relative", "Most that lengths are off at a root, over what is of second order."
    )
    tried: float = threshold(0.05, "relative", "Roots as near to one that was tried are left out.")
    probe: int = threshold(3, "count", "Newton steps that tell whether an end is promising.")
    promising: float = threshold(0.1, "relative", "Residual after them, at most.")
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
    _attempts: dict[float, Floats] = field(default_factory=dict)  # by the residual

    def steps(self, surfaces: int) -> Iterator[None]:
        """Search from the given vertices, then from so many realizations at most.

        These are in turn the smoothest of all, and the smoothest of those that the fewest moves from
        realization to realization lead to.  It stops after each, with `found` as it is then.  As long as
        nothing is found it goes on from the attempts that miss the lengths by least.
        """
        self._polish(self.vertices)
        if not self.found:
            self._search_from(self.vertices)
            yield
        for step in range(surfaces):
            left = [i for i, searched in enumerate(self.searched) if not searched]
            if left:
                i = min(left, key=lambda i: (self._moves[i] if step % 2 else 0, self._roughness[i]))
                self.searched[i] = True
                self._search_from(self.found[i], self._moves[i] + 1)
            elif not self.found and self._attempts:
                self._search_from(self._attempts.pop(min(self._attempts)))
            else:
                return
            yield

    @property
    def _unit(self) -> float:
        return float(self.lengths.mean())

    def _search_from(self, vertices: Floats, moves: int = 0) -> None:
        """Search from vertices; if nothing new is found, again with the softest motions set apart."""
        known = len(self.found)
        self._search(vertices, moves, 0)
        if len(self.found) == known:
            self._search(vertices, moves, SEARCH.softest)

    def _search(self, vertices: Floats, moves: int, hidden: int) -> None:
        expansion = LengthExpansion(self.system, vertices, self.lengths)
        near = SEARCH.beyond * self.distance
        self.recorder.factorizations += 2
        softest = softest_motions(expansion, self.motions)
        try:
            found = nearby_motions(expansion, softest, near * self._unit, hidden)
        except SingularMatrix:
            self.flexible += not hidden
            return
        tried: list[Floats] = []
        for group in self._groups(found, softest, hidden):
            predicted = predicted_motions(expansion, group, near, SEARCH.imaginary)
            self.incomplete += not predicted.complete
            for motion in predicted.motions:
                close = SEARCH.tried * np.abs(motion).max()
                if all(np.abs(motion - other).max() > close for other in tried):
                    tried.append(motion)
                    if _is_plausible(expansion, motion):
                        self._polish(vertices + motion, moves)

    def _groups(self, found: Motions, softest: Floats, hidden: int) -> list[Floats]:
        """The motions that are taken together: the nearest, then each of the others with those beside it.

        Where the lengths are missed, so are the softest, without which they may not be reached.
        """
        soft = softest[: min(hidden if self.found else SEARCH.softest, self.motions - 1)]
        count = self.motions - len(soft)
        size = np.linalg.norm(found.motions, axis=2)
        size = size / np.linalg.norm(size, axis=1, keepdims=True)
        together = size @ size.T
        np.fill_diagonal(together, np.inf)
        beside = np.argsort(-together, axis=1, kind="stable")[count:, : min(SEARCH.beside + 1, count)]
        groups = [found.motions[:count], *(found.motions[each] for each in beside)]
        return [np.concatenate([soft, group]) for group in groups]

    def _polish(self, vertices: Floats, moves: int = 0) -> None:
        """Add the realization that Newton's method leads to, if it is new and near enough."""
        start = self._residual(vertices)
        probed = self._annealed(vertices, SEARCH.probe)
        good = probed.residual <= max(SEARCH.promising * start, SEARCH.realized * self._unit)
        if good and self._is_known(probed.vertices, SEARCH.returns):
            return
        found = self._annealed(probed.vertices, SEARCH.steps) if good else probed
        if found.residual > SEARCH.realized * self._unit:
            if not self.found and found.vertices is not vertices:
                self._attempts[found.residual] = found.vertices
            return
        space, x = self.system.space, found.vertices
        if distance(x, self.vertices, space) > self.distance * self._unit:
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


def _is_plausible(expansion: LengthExpansion, motion: Floats) -> bool:
    """Whether the lengths at the end of a motion are off by less than what is of second order in it."""
    missed = np.linalg.norm(expansion.residuals_at(motion))
    return bool(missed <= SEARCH.defect * np.linalg.norm(expansion.bends(motion, motion)) / 2)
