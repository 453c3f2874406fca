"""Search over sequences of vertex reflections, from nearly right edge lengths to a realization.

Such a surface usually has a few vertices on the wrong side of their neighbors.  At a minimum of
``|r|^2 + mu |R x|^2``, `isoembed.aim.vertex_reflections` are tried; those that promise less energy are
followed by a descent of the whole surface (`isoembed.aim.energy_descent`).  mu decreases with the errors, so
that the two terms balance, and when no reflection helps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from isoembed.aim.acceptance import NEARLY, REALIZED
from isoembed.aim.anneal import anneal
from isoembed.aim.energy_descent import minimize_energy
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.schur_complement import Condensation
from isoembed.aim.search_state import SearchState
from isoembed.aim.vertex_reflections import GAIN, PATCHES, ReflectionTrial, ReflectionTrials
from isoembed.arrays import Floats
from isoembed.linalg import OutOfMemory, SingularMatrix
from isoembed.linalg.work import Budget
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem


def with_reflected_vertices(
    energy: RegularizedEnergy,
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    max_cost: float,
) -> Floats:
    """Reflect vertices on the wrong side of a surface that nearly has its lengths.

    If a search with nearly all lengths right ends, another one starts from the point where mu became small,
    and skips the first 1, 2, ... successful changes.

    Parameters
    ----------
    energy : RegularizedEnergy
        Energy of a metric in Euclidean space.
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
        Recorder of the work; solves and patches count as fractions of a factorization.
    max_cost : float
        Budget in factorizations.

    Returns
    -------
    ndarray, shape (V, 3)
        The surface found with the smallest residual.
    """
    search = _ReflectionSearch(energy, system, vertices, lengths, recorder, Budget(recorder.work, max_cost))
    search.follow(vertices, search.balanced_penalty(vertices))
    passed_over = 0
    while search.turn is not None and not (search.is_done or search.pass_over):
        passed_over += 1
        search.pass_over = passed_over
        search.follow(*search.turn)
    search.budget.close()
    return search.nearest


class _ReflectionSearch(SearchState):
    """The search by vertex reflections.

    Attributes
    ----------
    turn : tuple of ndarray and float, or None
        Surface and mu when mu became small.
    pass_over : int
        Number of successful changes to skip.
    """

    turn: tuple[Floats, float] | None = None
    pass_over = 0
    _newton_residual = np.inf  # residual at the last start of Newton's method

    @property
    def is_done(self) -> bool:
        """Whether a realization is found or the budget is exhausted."""
        return self.residual <= REALIZED or self.exhausted

    def balanced_penalty(self, x: Floats) -> float:
        """The mu that balances the two terms of the energy."""
        r = self.energy.residuals(x, self.lengths)
        rough = max(np.sum((self.energy.fit_residuals @ x) ** 2), np.finfo(float).tiny)
        return 2.0 * float(r @ r / rough)  # mu |R x|^2 over |r|^2 in balance

    def keep(self, x: Floats) -> float:
        """Keep a surface, and the one that Newton's method finds from it."""
        residual = super().keep(x)
        if residual <= min(
            NEARLY, 0.5 * self._newton_residual
        ):  # decrease of the residual before another attempt
            self._newton_residual = residual
            super().keep(anneal(self.system, x, self.lengths, self.recorder).vertices)
        return residual

    def descended(self, x: Floats, mu: float, max_cost: float = np.inf) -> Floats:
        """The minimum of the energy, with a limited number of factorizations."""
        descent = Budget(self.recorder.work, max_cost)

        def is_enough(_: Floats) -> bool:
            return descent.exhausted or self.exhausted

        x = minimize_energy(self.energy, x, self.lengths, mu, self.recorder, is_enough)
        self.keep(x)
        self.show(x)
        return x

    def follow(self, x: Floats, mu: float) -> None:
        """Decrease mu from an initial value, and apply successful reflections, until none helps."""
        x, vain, was_fine = self.descended(x, mu), 0, False
        while not self.is_done:
            balanced = self.balanced_penalty(x)
            if balanced < 0.9 * mu:
                x, mu = self.descended(x, balanced), balanced
                continue
            # Mean edge lengths^2; below it, all kinds of changes are tried.
            fine = mu < 1e-8 * self.energy.unit**2
            if fine and not was_fine:
                vain, was_fine = 0, True
                self.turn = self.turn or (x, mu)
            better = self.better(x, mu, None if fine else 1 + vain)
            if better is not None:
                x, vain = better, 0
                continue
            vain += 1
            if fine and vain >= 2:  # values of mu without success
                return
            mu *= 0.3
            x = self.descended(x, mu)

    def better(self, x: Floats, mu: float, kinds: int | None) -> Floats | None:
        """A minimum of lower energy reached by a reflection; None if none is found.

        Single vertices are reflected in a number of kinds of patches; None means all kinds of changes.
        """
        try:
            surface = Condensation(self.energy, x, self.lengths, mu, self.budget.spend)
        except (SingularMatrix, OutOfMemory):
            return None
        changes = ReflectionTrials(surface, lambda: self.is_done)
        for tries in _tries(changes, kinds):
            found = self.first_better(surface, tries)
            if found is not None or self.is_done:
                return found
        return None

    def first_better(
        self, surface: Condensation, tries: Sequence[Sequence[ReflectionTrial]]
    ) -> Floats | None:
        """The first minimum of lower energy reached by combined changes."""
        vain = 0
        for changes in tries:
            trial = surface.vertices + sum(change.displacement for change in changes)
            # Beyond such growth, no descent succeeds.
            if self.energy.value(trial, self.lengths, surface.mu) > 1e4 * surface.value:
                continue
            end = self.descended(trial, surface.mu, 20)  # factorizations
            if self.is_done:
                return end
            if self.energy.value(end, self.lengths, surface.mu) < (1 - GAIN) * surface.value:
                if not self.pass_over:
                    return end
                self.pass_over -= 1
            vain += 1
            if vain == 3:  # unsuccessful descents from changes of one kind
                break
        return None


def _tries(changes: ReflectionTrials, kinds: int | None) -> Iterator[list[list[ReflectionTrial]]]:
    """Trials by kind: lists of changes to apply together."""
    for found in changes.singles(len(PATCHES) if kinds is None else kinds):
        yield _one_by_one(found)
    if kinds is None:
        shallow = changes.shallow()
        yield _halves(shallow)
        yield _one_by_one(shallow)
        for found in changes.pairs():
            yield _one_by_one(found)


def _one_by_one(changes: Iterable[ReflectionTrial]) -> list[list[ReflectionTrial]]:
    return [[change] for change in changes]


def _halves(changes: list[ReflectionTrial]) -> list[list[ReflectionTrial]]:
    """All, the better half, and so on, down to two."""
    halves = []
    while len(changes) > 1:
        halves.append(changes)
        changes = changes[: len(changes) // 2]
    return halves
