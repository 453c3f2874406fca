"""Local search: reflection of patches on the wrong side, one by one.

A continuation from a convex surface that fails is usually right except for some patches: a pit has become a
bump, or a vertex is on the other side of its neighbors.  The energy ``|r|^2 + mu |R x|^2``
(`isoembed.aim.regularized_energy`) then has a local minimum, with the largest residuals at these patches.
Disks of triangles with the largest residuals are moved to the position predicted by their surroundings, or as
far beyond it, and relaxed with the rest of the surface fixed.  Changes that lower the energy are kept.  This
is repeated for a decreasing sequence of mu.

From each mu the penalty is also released, with different measures of smoothness: as mu vanishes, vertices
nearly in the plane of their neighbors move to one side, and no measure predicts it reliably.  If the final
residuals are small, `isoembed.aim.finishing_newton` continues.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, eye_array

from isoembed.aim.acceptance import NEARLY, REALIZED
from isoembed.aim.anneal import anneal
from isoembed.aim.clamped_patch import ClampedPatch
from isoembed.aim.energy_descent import minimize_energy
from isoembed.aim.finishing_newton import finish
from isoembed.aim.regularized_continuation import FADE, FADE_STEPS, release_penalty
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.search_state import SearchState
from isoembed.arrays import Floats, Indices, Mask
from isoembed.linalg.work import Budget
from isoembed.nonlinear.continuation import penalty_continuation
from isoembed.progress.stages import StageRecorder
from isoembed.surface.local_fit import sums_at_ends
from isoembed.surface.rigidity import LengthSystem

WEIGHTS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # mean edge lengths^2: mu, in turn
RINGS = 5  # radius of the largest disks, in edges; the smallest are single vertices
DISKS = 12  # disks of each radius in a sweep
MOVED = 0.3  # share of the root of the largest residual; smaller moves fell back
COARSE = 150  # largest number of vertices for a search by lengths alone
COARSE_STEPS = 25  # Gauss-Newton steps after the reflection of a vertex
CONVERGED = 1e-6  # relative decrease of |r|^2 at rounding


class Searched(NamedTuple):
    """End of a search, and the end of a stage with the smallest residual, each (V, 3).

    The search continues from surfaces of lower energy, which need not be nearer to the lengths.
    """

    end: Floats
    nearest: Floats


def local_search(
    energy: RegularizedEnergy,
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    max_cost: float,
) -> Searched:
    """Reflect patches on the wrong side of a surface that misses its lengths.

    Parameters
    ----------
    energy : RegularizedEnergy
        Energy of a metric in Euclidean space.
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
        Recorder of the work; a factorization of a patch counts by its share of the vertices.
    max_cost : float
        Budget in factorizations; a step in progress is completed.

    Returns
    -------
    Searched
    """
    budget = Budget(recorder.work, max_cost)
    search = _LocalSearch(energy, system, vertices, lengths, recorder, budget)
    x = vertices
    # Share of the search guided by smoothness.
    budget.limit = 0.5 * max_cost if search.is_coarse else max_cost - FADE_STEPS
    for weight in WEIGHTS:
        mu = weight * energy.unit**2
        x = search.at(x, mu)
        if search.is_done(x):
            break
        # Mean edge lengths^2; below it the penalty is released.
        is_small = weight <= 1e-4 and not search.is_coarse
        if is_small and search.ends_realized(x, mu):
            break
    budget.limit = max_cost
    if search.is_coarse:
        x = search.mirrored(x)
    elif search.realization is None:
        x, _ = release_penalty(energy, x, lengths, mu, recorder, is_done=lambda: budget.exhausted)
    budget.close()
    end = x if search.realization is None else search.realization
    search.keep(end)
    return Searched(end, search.nearest)


def misses_locally(energy: RegularizedEnergy, vertices: Floats, lengths: Floats) -> bool:
    """Whether the residuals are concentrated in no more places than there are disks in a sweep.

    Patches on the wrong side cause such residuals.  Noise spreads them over the whole surface, where
    reflecting a few patches does not help.
    """
    squares = energy.residuals(vertices, lengths) ** 2
    rings = RINGS
    reached = 3 * DISKS * (1 + 3 * rings * (rings + 1))  # edges, three for each vertex
    return len(squares) <= reached or bool(
        np.partition(squares, -reached)[-reached:].sum() > 0.9 * squares.sum()
    )


class _LocalSearch(SearchState):
    """The local search, with the realization found."""

    def __init__(
        self,
        energy: RegularizedEnergy,
        system: LengthSystem,
        vertices: Floats,
        lengths: Floats,
        recorder: StageRecorder,
        budget: Budget,
    ) -> None:
        super().__init__(energy, system, vertices, lengths, recorder, budget)
        self.realization: Floats | None = None
        self.newton_start: Floats | None = None  # last start of Newton's method
        n = energy.triangulation.n_vertices
        self.is_coarse = n <= COARSE
        self.patch_cost = (
            0.05 if self.is_coarse else 1.0
        )  # cost of a patch with all vertices, in factorizations
        near = csr_array(energy.triangulation.adjacency + eye_array(n))
        near.data[:] = 1.0
        self.disks = [csr_array(eye_array(n))]
        for _ in range(RINGS):
            wider = csr_array(self.disks[-1] @ near)
            wider.data[:] = 1.0
            self.disks.append(wider)
        self.near = near

    def patch(self, vertices: Indices, mu: float) -> ClampedPatch:
        """Patch of these vertices, with its cost charged to the budget."""

        def spend(share: float) -> None:
            self.budget.spend(self.patch_cost * share)

        return ClampedPatch.of(self.energy, self.lengths, vertices, mu, spend)

    def is_done(self, x: Floats) -> bool:
        """Whether a realization is found or the budget is exhausted."""
        self.keep(x)
        return self.is_realized(x) or self.exhausted

    def is_realized(self, x: Floats) -> bool:
        """Whether a realization is found, after trying Newton's method from a new surface."""
        newton_start, self.newton_start = self.newton_start, x
        if self.realization is None and x is not newton_start and self.largest_residual(x) <= NEARLY:
            found = anneal(self.system, x, self.lengths, self.recorder).vertices
            self.keep(found)
            if self.largest_residual(found) <= REALIZED:
                self.realization = found
        return self.realization is not None

    def ends_realized(self, x: Floats, mu: float) -> bool:
        """Whether the search ends in the limit of vanishing mu, by a realization or the budget."""
        for energy in (self.energy.coarser(x), self.energy):
            end = self.released(energy, x, mu)
            if self.is_done(end):
                return True
            if self.largest_residual(end) <= NEARLY:
                end = finish(self.system, end, self.lengths, self.recorder, lambda _: self.exhausted)
                if self.is_done(end):
                    return True
        return False

    def released(self, energy: RegularizedEnergy, x: Floats, mu: float) -> Floats:
        """Surface in the limit of vanishing mu, for one measure of smoothness."""

        def minimized(x: Floats, mu: float) -> Floats:
            x = minimize_energy(energy, x, self.lengths, mu, self.recorder, lambda _: self.exhausted)
            self.show(x)
            return x

        return penalty_continuation(
            x, minimized, self.largest_residual, mu, FADE, 12, REALIZED, lambda: self.exhausted
        )[0]

    def at(self, x: Floats, mu: float) -> Floats:
        """The surface of least energy found for one mu."""
        x = self.settled(x, mu)
        stale = np.ones(len(x), dtype=bool)
        while not self.is_done(x):
            freed, _ = release_penalty(
                self.energy, x, self.lengths, mu, self.recorder, is_done=lambda: self.exhausted
            )
            if self.is_done(freed):
                return freed
            turned = self.sweep(x, mu, stale)
            if turned is x:
                break
            relaxed = self.settled(turned, mu)
            moved = np.linalg.norm(relaxed - x, axis=1) > MOVED * self.reach(x)
            stale, x = np.asarray(self.near @ moved > 0), relaxed
        return x

    def reach(self, x: Floats) -> float:
        """Estimated distance between the surfaces on both sides of a barrier, from the residual on it."""
        return self.energy.unit * float(np.sqrt(self.largest_residual(x)))

    def settled(self, x: Floats, mu: float) -> Floats:
        """The local minimum of the energy, by Gauss-Newton steps."""
        return self.energy.minimized(x, self.lengths, mu, 0.002, 20, self.recorder, lambda: self.exhausted)

    def sweep(self, x: Floats, mu: float, stale: Mask) -> Floats:
        """Try the disks of all sizes with a ``stale`` vertex; return x itself if none is reflected."""
        found, enough = x, 1e-4 * self.energy.value(x, self.lengths, mu)  # significant decrease of the energy
        for disks in self.disks:
            self.show(found)
            for center in self.chosen(found, disks):
                disk = np.sort(disks[[center]].indices)
                if stale[disk].any():
                    found = self.turned(found, disk, mu, enough)
                if self.exhausted:
                    return found
        return found

    def chosen(self, x: Floats, disks: csr_array) -> Iterator[int]:
        """Centers of the disks with the largest residuals; none is in the disk of another."""
        squares = self.energy.residuals(x, self.lengths) ** 2
        residual_sums = disks @ sums_at_ends(self.energy.triangulation, squares / 2)
        free, count = residual_sums > 1e-4 * squares.sum(), 0  # disks with less of |r|^2 are skipped
        free &= np.diff(disks.indptr) <= len(x) / 2  # a larger disk would be the complement
        for center in np.argsort(-residual_sums, kind="stable").tolist():
            if not free[center]:
                continue
            yield center
            free[disks[[center]].indices] = False
            count += 1
            if count == DISKS:
                return

    def turned(self, x: Floats, disk: Indices, mu: float, enough: float) -> Floats:
        """The surface with a disk reflected, if its energy is lower by at least ``enough``; else x itself."""
        patch = self.patch(self.grown(disk, 2), mu)  # two rings around the disk are relaxed, too
        offset = patch.offset(x, disk)
        min_distance = MOVED * self.reach(x)
        # Once and twice the distance to the predicted position.
        for motion in (*(times * offset for times in (1.0, 2.0)), self.reflection(x, disk)):
            trial = x.copy()
            trial[disk] += motion
            if not np.isfinite(trial).all():
                continue
            before = patch.value(x)
            found, after = patch.relaxed(trial)
            if np.linalg.norm(found - x, axis=1).max() < min_distance:
                continue
            if enough > before - after > -0.5 * before:  # growth possibly due to too few rings
                wide = self.patch(self.grown(disk, 5), mu)  # more rings, for a decision
                before = wide.value(x)
                found, after = wide.relaxed(found)
            if before - after > enough:
                return found
        return x

    def mirrored(self, x: Floats) -> Floats:
        """The surface of least residual found by reflecting vertices or pairs of neighbors.

        For coarse surfaces, on which smoothness is no guide.
        """
        whole = self.patch(np.arange(len(x)), 0.0)
        rng, adjacency = np.random.default_rng(0), self.energy.triangulation.adjacency
        x, value = whole.relaxed(x, COARSE_STEPS, CONVERGED)
        tried: set[int] = set()
        while not self.is_done(x):
            squares = self.energy.residuals(x, self.lengths) ** 2
            residual_sums = sums_at_ends(self.energy.triangulation, squares)
            left = [v for v in np.argsort(-residual_sums, kind="stable").tolist() if v not in tried]
            self.show(x)
            if left:
                tried.add(left[0])
                flipped = [left[0]]
            else:
                first = int(rng.choice(len(x), p=residual_sums / residual_sums.sum()))
                flipped = [first, int(rng.choice(adjacency[[first]].indices))]
            trial = x
            for v in flipped:
                trial = trial.copy()
                trial[v] += self.reflection(trial, np.array([v]))[0]
            found, reached = whole.relaxed(trial, COARSE_STEPS, CONVERGED)
            if reached < (1 - CONVERGED) * value:
                x, value = found, reached
                tried.clear()
        return x

    def reflection(self, x: Floats, disk: Indices) -> Floats:
        """The motion that reflects a disk in the plane of its rim; a plane rim preserves the lengths."""
        rim = x[np.setdiff1d(self.near[disk].indices, disk)]
        middle = rim.mean(axis=0)
        normal = np.linalg.svd(rim - middle, full_matrices=False)[2][-1]
        return -2 * np.outer((x[disk] - middle) @ normal, normal)

    def grown(self, patch: Indices, rings: int) -> Indices:
        """A patch with rings of neighbors."""
        for _ in range(rings):
            patch = np.unique(self.near[patch].indices)
        return patch
