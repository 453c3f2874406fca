"""Local search: patches that a pull-back left on the wrong side are turned over, one by one.

A surface that was followed from a convex one and got lost is, as a rule, right but for some patches: a pit is
a bump, a vertex stands on the other side of its neighbors.  Its energy, ``|r|^2 + mu |R x|^2``
(`isoembed.aim.regularized_energy`), is then a local minimum, and the lengths are missed at these patches.
Disks of triangles where they are missed most are put where their surroundings expect them, or as far beyond,
and relaxed with the rest of the surface held.  What lowers the energy is kept.  So for one mu after the
other.

From each mu the surface is let go, by other measures of smoothness, too: as mu vanishes, vertices that are
nearly in the plane of their neighbors choose their sides, and no measure always knows which.  Where little is
missed in the end, `isoembed.aim.completion` goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse import csr_array, eye_array

from isoembed.aim.anneal import anneal
from isoembed.aim.completion import completed
from isoembed.aim.energy_descent import descended
from isoembed.aim.regularized_continuation import let_go
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices, Mask
from isoembed.progress.stages import StageRecorder
from isoembed.surface.local_fit import sums_at_ends
from isoembed.surface.rigidity import LengthSystem
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class LocalSearchThresholds:
    """Thresholds of the local search."""

    weights: tuple[float, ...] = threshold(
        (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8), "mean edge lengths^2", "mu, in turn."
    )
    known: float = threshold(1e-4, "mean edge lengths^2", "mu from which surfaces are let go, at most.")
    rings: int = threshold(5, "count", "Radius of the disks at most, in edges; the least is a vertex.")
    disks: int = threshold(12, "count", "Disks of each radius that are tried in a sweep.")
    share: float = threshold(1e-4, "relative", "Share of |r|^2 in a disk that is worth a try.")
    beyond: tuple[float, ...] = threshold(
        (1.0, 2.0), "relative", "Moves of a disk, in its distances from where it is expected."
    )
    margin: int = threshold(2, "count", "Rings about a disk that are relaxed with it.")
    wide: int = threshold(5, "count", "The same where this is too few to tell.")
    doubtful: float = threshold(0.5, "relative", "Growth of the energy that may be for want of them.")
    moved: float = threshold(
        0.3, "relative", "Share of the root of the largest residual: a smaller move fell back."
    )
    gain: float = threshold(1e-4, "relative", "Decrease of the energy that counts.")
    local_steps: int = threshold(12, "count", "Gauss-Newton steps of a patch at most.")
    settled: float = threshold(0.998, "relative", "Share of the energy that a step leaves at a minimum.")
    steps: int = threshold(20, "count", "Gauss-Newton steps of the surface at most.")
    fade: float = threshold(0.1, "relative", "Factor of mu from step to step as a surface is let go.")
    faded: int = threshold(12, "count", "Such steps at most.")
    stalled: float = threshold(0.9, "relative", "Share of the residual that two steps leave if it is lost.")
    exact: float = threshold(1e-11, "mean edge lengths", "Largest residual of a realization.")
    damping: float = threshold(1e-3, "relative", "Levenberg-Marquardt damping of a patch at first.")
    stiffer: float = threshold(5.0, "relative", "Factor of the damping after a step uphill.")
    softer: float = threshold(0.2, "relative", "Factor of the damping after a step downhill.")
    uphill: int = threshold(6, "count", "Steps uphill in turn that end the relaxation of a patch.")
    coarse: int = threshold(150, "count", "Vertices of a surface at most that is searched for lengths alone.")
    guided: float = threshold(0.5, "relative", "Share of its search that smoothness guides.")
    dense: float = threshold(0.05, "relative", "Cost of a factorization of its patches, by their vertices.")
    coarse_steps: int = threshold(25, "count", "Gauss-Newton steps after a vertex was mirrored at most.")
    converged: float = threshold(1e-6, "relative", "Decrease of |r|^2 that is none.")
    close: float = threshold(1e-6, "mean edge lengths", "From here Newton's method, or completion, is tried.")


LOCAL_SEARCH = LocalSearchThresholds()


def local_search(
    energy: RegularizedEnergy,
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    most: float,
) -> Floats:
    """Turn over what is on the wrong side of a surface that misses its lengths.

    Parameters
    ----------
    energy : RegularizedEnergy
        Of a metric in Euclidean space.
    system : LengthSystem
        Of its triangulation.
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
        Counts factorizations; one of a patch counts as its share of the vertices.
    most : float
        Factorizations after which nothing more is turned.  The relaxation that has begun is ended, and the
        first is made whatever this is: together they take some tens.

    Returns
    -------
    ndarray, shape (V, 3)
        Where it ended.
    """
    search = _LocalSearch(energy, system, lengths, recorder, most)
    x = vertices
    if search.is_coarse:
        search.most = LOCAL_SEARCH.guided * most
    for weight in LOCAL_SEARCH.weights:
        mu = weight * energy.unit**2
        x = search.at(x, mu)
        if search.is_done(x):
            break
        known = weight <= LOCAL_SEARCH.known and not search.is_coarse
        if known and search.ends_realized(x, mu):
            break
    if search.is_coarse:
        search.most = most
        x = search.mirrored(x)
    elif search.realization is None:
        x, _ = let_go(energy, x, lengths, mu, recorder)
    recorder.factorizations += round(search.local)
    return x if search.realization is None else search.realization


class _LocalSearch:
    """The search, what it has spent, and the realization that it has found."""

    def __init__(
        self,
        energy: RegularizedEnergy,
        system: LengthSystem,
        lengths: Floats,
        recorder: StageRecorder,
        most: float,
    ) -> None:
        self.energy, self.system, self.lengths, self.recorder = energy, system, lengths, recorder
        self.realization: Floats | None = None
        self.asked: Floats | None = None  # the surface from which Newton's method was tried last
        self.begun, self.most, self.local = recorder.factorizations, most, 0.0
        n = energy.triangulation.n_vertices
        self.is_coarse = n <= LOCAL_SEARCH.coarse
        self.cost = LOCAL_SEARCH.dense if self.is_coarse else 1.0
        near = csr_array(energy.triangulation.adjacency + eye_array(n))
        near.data[:] = 1.0
        self.disks = [csr_array(eye_array(n))]
        for _ in range(LOCAL_SEARCH.rings):
            wider = csr_array(self.disks[-1] @ near)
            wider.data[:] = 1.0
            self.disks.append(wider)
        self.near = near

    @property
    def exhausted(self) -> bool:
        """Whether as much is spent as may be."""
        return self.recorder.factorizations - self.begun + self.local >= self.most

    def largest_residual(self, x: Floats) -> float:
        """Largest error of the lengths, in mean edge lengths."""
        return float(np.abs(self.energy.residuals(x, self.lengths)).max()) / self.energy.unit

    def show(self, x: Floats) -> None:
        """Tell a listener of a surface, and of the share of the search that is done."""
        spent = self.recorder.factorizations - self.begun + self.local
        residual = float(np.abs(self.energy.residuals(x, self.lengths)).max())
        self.recorder.show(vertices=x, residual=residual, done=min(spent / self.most, 1.0))

    def is_done(self, x: Floats) -> bool:
        """Whether there is no more to do, or may not be done."""
        return self.is_realized(x) or self.exhausted

    def is_realized(self, x: Floats) -> bool:
        """Whether a realization is found, now that the surface is this."""
        asked, self.asked = self.asked, x
        if self.realization is None and x is not asked and self.largest_residual(x) <= LOCAL_SEARCH.close:
            found = anneal(self.system, x, self.lengths, self.recorder).vertices
            if self.largest_residual(found) <= LOCAL_SEARCH.exact:
                self.realization = found
        return self.realization is not None

    def ends_realized(self, x: Floats, mu: float) -> bool:
        """Whether there is no more to do: a realization is found as mu vanishes, or all is spent."""
        for energy in (self.energy.coarser(x), self.energy):
            end = self.released(energy, x, mu)
            if self.is_done(end):
                return True
            if self.largest_residual(end) <= LOCAL_SEARCH.close:
                end = completed(self.system, end, self.lengths, self.recorder, lambda _: self.exhausted)
                if self.is_done(end):
                    return True
        return False

    def released(self, energy: RegularizedEnergy, x: Floats, mu: float) -> Floats:
        """Where a surface ends as mu vanishes, with a measure of smoothness."""
        before, slow = np.inf, 0
        for _ in range(LOCAL_SEARCH.faded):
            x = descended(energy, x, self.lengths, mu, self.recorder, lambda _: self.exhausted)
            self.show(x)
            residual = self.largest_residual(x)
            slow = slow + 1 if residual > LOCAL_SEARCH.stalled * before else 0
            if slow == 2 or residual <= LOCAL_SEARCH.exact or self.exhausted:
                break
            before = residual
            mu *= LOCAL_SEARCH.fade
        return x

    def at(self, x: Floats, mu: float) -> Floats:
        """The least energy that is met with one mu."""
        x = self.settled(x, mu)
        stale = np.ones(len(x), dtype=bool)
        while not self.is_done(x):
            freed, _ = let_go(self.energy, x, self.lengths, mu, self.recorder)
            if self.is_done(freed):
                return freed
            turned = self.sweep(x, mu, stale)
            if turned is x:
                break
            relaxed = self.settled(turned, mu)
            moved = np.linalg.norm(relaxed - x, axis=1) > LOCAL_SEARCH.moved * self.reach(x)
            stale, x = np.asarray(self.near @ moved > 0), relaxed
        return x

    def reach(self, x: Floats) -> float:
        """How far apart surfaces are that stand on different sides, by the residual that is between them."""
        return self.energy.unit * float(np.sqrt(self.largest_residual(x)))

    def settled(self, x: Floats, mu: float) -> Floats:
        """The local minimum of the energy, as far as Gauss-Newton steps lead."""
        value = self.energy.value(x, self.lengths, mu)
        for _ in range(LOCAL_SEARCH.steps):
            x = self.energy.relaxed(x, self.lengths, mu, 0.0, self.recorder)
            before, value = value, self.energy.value(x, self.lengths, mu)
            if not value < LOCAL_SEARCH.settled * before:
                break
        return x

    def sweep(self, x: Floats, mu: float, stale: Mask) -> Floats:
        """Try disks of all sizes once, those with a vertex that is ``stale``; x itself if none is turned."""
        found, enough = x, LOCAL_SEARCH.gain * self.energy.value(x, self.lengths, mu)
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
        """Centers of disks in which the lengths are missed most; none is in the disk of another."""
        squares = self.energy.residuals(x, self.lengths) ** 2
        missed = disks @ sums_at_ends(self.energy.triangulation, squares / 2)
        free, count = missed > LOCAL_SEARCH.share * squares.sum(), 0
        free &= np.diff(disks.indptr) <= len(x) / 2  # else it is the rest that would be turned
        for center in np.argsort(-missed, kind="stable").tolist():
            if not free[center]:
                continue
            yield center
            free[disks[[center]].indices] = False
            count += 1
            if count == LOCAL_SEARCH.disks:
                return

    def turned(self, x: Floats, disk: Indices, mu: float, enough: float) -> Floats:
        """The surface with a disk turned over, if that is better by ``enough``; else x itself."""
        patch = _Patch.of(self, self.grown(disk, LOCAL_SEARCH.margin), mu)
        offset = patch.offset(x, disk)
        least = LOCAL_SEARCH.moved * self.reach(x)
        for motion in (*(times * offset for times in LOCAL_SEARCH.beyond), self.reflection(x, disk)):
            trial = x.copy()
            trial[disk] += motion
            if not np.isfinite(trial).all():
                continue
            before = patch.value(x)
            found, after = patch.relaxed(trial)
            if np.linalg.norm(found - x, axis=1).max() < least:
                continue
            if enough > before - after > -LOCAL_SEARCH.doubtful * before:
                wide = _Patch.of(self, self.grown(disk, LOCAL_SEARCH.wide), mu)
                before = wide.value(x)
                found, after = wide.relaxed(found)
            if before - after > enough:
                return found
        return x

    def mirrored(self, x: Floats) -> Floats:
        """The least errors of the lengths that are met by reflecting vertices, or pairs of neighbors.

        For coarse surfaces, on which smoothness tells little.
        """
        whole = _Patch.of(self, np.arange(len(x)), 0.0)
        rng, adjacency = np.random.default_rng(0), self.energy.triangulation.adjacency
        x, value = whole.relaxed(x, LOCAL_SEARCH.coarse_steps, LOCAL_SEARCH.converged)
        tried: set[int] = set()
        while not self.is_done(x):
            squares = self.energy.residuals(x, self.lengths) ** 2
            missed = sums_at_ends(self.energy.triangulation, squares)
            left = [v for v in np.argsort(-missed, kind="stable").tolist() if v not in tried]
            self.show(x)
            if left:
                tried.add(left[0])
                flipped = [left[0]]
            else:
                first = int(rng.choice(len(x), p=missed / missed.sum()))
                flipped = [first, int(rng.choice(adjacency[[first]].indices))]
            trial = x
            for v in flipped:
                trial = trial.copy()
                trial[v] += self.reflection(trial, np.array([v]))[0]
            found, reached = whole.relaxed(trial, LOCAL_SEARCH.coarse_steps, LOCAL_SEARCH.converged)
            if reached < (1 - LOCAL_SEARCH.converged) * value:
                x, value = found, reached
                tried.clear()
        return x

    def reflection(self, x: Floats, disk: Indices) -> Floats:
        """The motion that reflects a disk in the plane of its rim: lengths are kept if that is plane."""
        rim = x[np.setdiff1d(self.near[disk].indices, disk)]
        middle = rim.mean(axis=0)
        normal = np.linalg.svd(rim - middle, full_matrices=False)[2][-1]
        return -2 * np.outer((x[disk] - middle) @ normal, normal)

    def grown(self, patch: Indices, rings: int) -> Indices:
        """A patch with rings of neighbors."""
        for _ in range(rings):
            patch = np.unique(self.near[patch].indices)
        return patch


@dataclass(frozen=True, eq=False)
class _Patch:
    """The energy as a function of a few vertices, the others being held.

    Attributes
    ----------
    search : _LocalSearch
    vertices : ndarray of int, shape (n,)
        Those that move.
    edges, lengths : ndarray, shape (m, 2), (m,)
        Edges that change, and the lengths that they are to have.
    place : ndarray of int, shape (m, 2)
        The ends of edges among the vertices; n where they are held.
    rows : sparse, shape (k, V)
        The rows of R that change.
    columns : ndarray, shape (k, n)
        Their columns.
    stiffness : ndarray, shape (n, n)
        ``mu R^T R``.
    mu : float
    """

    search: _LocalSearch
    vertices: Indices
    edges: Indices
    lengths: Floats
    place: Indices
    rows: csr_array
    columns: Floats
    stiffness: Floats
    mu: float

    @classmethod
    def of(cls, search: _LocalSearch, vertices: Indices, mu: float) -> _Patch:
        """That of these vertices."""
        triangulation, R = search.energy.triangulation, search.energy.fit_residuals
        n = len(vertices)
        changing = np.unique(triangulation.incidence[vertices].indices)
        edges = triangulation.edges[changing]
        place = np.full(triangulation.n_vertices, n)
        place[vertices] = np.arange(n)
        rows = R[np.unique(search.energy.fit_residuals_transposed[vertices].indices)]
        columns = rows[:, vertices].toarray()
        stiffness = mu * (columns.T @ columns)
        return cls(
            search, vertices, edges, search.lengths[changing], place[edges], rows, columns, stiffness, mu
        )

    def value(self, x: Floats) -> float:
        """The part of the energy that changes."""
        r, rough, _ = self._terms(x)
        return float(r @ r + self.mu * np.sum(rough**2))

    def offset(self, x: Floats, disk: Indices) -> Floats:
        """What is to be added to vertices of the patch for R x to be least, shape (k, 3)."""
        of = np.searchsorted(self.vertices, disk)
        columns = self.columns[:, of]
        return -np.linalg.lstsq(columns, self.rows @ x, rcond=None)[0]

    def relaxed(
        self,
        x: Floats,
        steps: int = LOCAL_SEARCH.local_steps,
        settled: float = 1 - LOCAL_SEARCH.settled,
    ) -> tuple[Floats, float]:
        """The local minimum near x, and its part of the energy, by Levenberg-Marquardt."""
        n, damping = len(self.vertices), LOCAL_SEARCH.damping
        r, rough, directions = self._terms(x)
        value = float(r @ r + self.mu * np.sum(rough**2))
        held = np.kron(self.stiffness, np.eye(3))
        for _ in range(steps):
            gradient = self.mu * (self.columns.T @ rough)
            blocks = np.zeros((n + 1, n + 1, 3, 3))
            pull = np.zeros((n + 1, 3))
            products = np.einsum("ei,ej->eij", directions, directions)
            for sign, end in ((1.0, 0), (-1.0, 1)):
                np.add.at(pull, self.place[:, end], sign * directions * r[:, None])
                np.add.at(blocks, (self.place[:, end], self.place[:, end]), products)
            blocks[self.place[:, 0], self.place[:, 1]] -= products
            blocks[self.place[:, 1], self.place[:, 0]] -= products
            matrix = blocks[:n, :n].transpose(0, 2, 1, 3).reshape(3 * n, 3 * n) + held
            gradient = (gradient + pull[:n]).ravel()
            for _ in range(LOCAL_SEARCH.uphill):
                self.search.local += self.search.cost * n / len(x)
                matrix_damped = matrix.copy()
                matrix_damped[np.diag_indices(3 * n)] += damping
                try:
                    factor = cho_factor(matrix_damped, overwrite_a=True, check_finite=False)
                except LinAlgError:
                    damping *= LOCAL_SEARCH.stiffer
                    continue
                trial = x.copy()
                trial[self.vertices] -= cho_solve(factor, gradient, check_finite=False).reshape(-1, 3)
                r_trial, rough_trial, directions_trial = self._terms(trial)
                reached = float(r_trial @ r_trial + self.mu * np.sum(rough_trial**2))
                if reached < value:
                    break
                damping *= LOCAL_SEARCH.stiffer
            else:
                return x, value
            enough = value - reached < settled * value
            x, r, rough, directions, value = trial, r_trial, rough_trial, directions_trial, reached
            damping *= LOCAL_SEARCH.softer
            if enough:
                break
        return x, value

    def _terms(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Errors of the lengths, R x, and the nonzeros of J."""
        d = x[self.edges[:, 0]] - x[self.edges[:, 1]]
        lengths = self.lengths
        r = (np.einsum("ei,ei->e", d, d) - lengths**2) / (2 * lengths)
        return r, self.rows @ x, d / lengths[:, None]
