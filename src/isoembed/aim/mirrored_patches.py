"""Mirrored patches: realizations in which dents are bumps, and bumps dents.

A path of smooth surfaces from a convex one comes to a dent by way of a flat spot, and may leave it on the
wrong side.  Where the metric has a dent (`isoembed.metric.dents`), what the path has made of it is reflected:
each vertex of the patch in the harmonic surface that its rim spans, a plane if the rim is plane.  From there
a few steps of the regularized continuation lead to the lengths, if they lead to any surface at all.

Of k patches there are 2^k choices.  A choice is judged by its energy after two steps; the best is found by
descent, patch by patch, and brought to the lengths.  From a realization its neighbors are tried, which differ
in one patch, and from those that are realizations theirs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array

from isoembed.aim.anneal import anneal
from isoembed.aim.regularized_continuation import CONTINUATION, let_go
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices, Mask
from isoembed.linalg import Factor, factor_general
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.measures import vertex_normals
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class MirrorThresholds:
    """Thresholds of the search among mirrored patches."""

    smallest_cotangent: float = threshold(0.01, "relative", "Smaller weights could fold a harmonic surface.")
    weights: tuple[float, ...] = threshold(
        (0.1, 0.01), "mean edge lengths^2", "mu of the steps after a reflection, in turn."
    )
    exact: float = threshold(1e-10, "mean edge lengths", "Largest residual of a realization.")
    patches: int = threshold(8, "count", "Patches at most: those with the most curvature on their caps.")
    finished: int = threshold(8, "count", "Choices that are brought to the lengths, at most.")
    failures: int = threshold(2, "count", "Neighbors of realizations that are none; then no more are tried.")


MIRROR = MirrorThresholds()

Choice = frozenset[int]
"""The patches that are reflected."""

NONE = Choice()


@dataclass(frozen=True, eq=False)
class HarmonicPatch:
    """A patch, and the harmonic surface that its rim spans.

    Attributes
    ----------
    inside : ndarray of int, shape (n,)
        The vertices of the patch.
    factor : Factor
        Of the Laplacian among them.
    coupling : csr_array, shape (n, V)
        The Laplacian between them and all others.
    """

    inside: Indices
    factor: Factor
    coupling: csr_array

    @classmethod
    def of(cls, laplacian: csr_array, patch: Mask) -> HarmonicPatch:
        """Of the vertices of a mask, (V,), by the Laplacian of the metric."""
        inside, rows = np.flatnonzero(patch), laplacian[patch]
        coupling = csr_array(rows.multiply(~patch))
        return cls(inside, factor_general(csc_array(rows[:, inside])), coupling)

    def reflected(self, faces: Indices, vertices: Floats) -> Floats:
        """The surface with the vertices of the patch on the other side of the harmonic surface."""
        spanned = vertices.copy()
        spanned[self.inside] = -self.factor.solve(self.coupling @ vertices)
        normals = vertex_normals(faces, spanned)[self.inside]
        height = np.einsum("ij,ij->i", vertices[self.inside] - spanned[self.inside], normals)
        reflected = vertices.copy()
        reflected[self.inside] -= 2 * height[:, None] * normals
        return reflected


def mirrored_realizations(
    metric: PolyhedralMetric,
    system: LengthSystem,
    energy: RegularizedEnergy,
    surface: Floats,
    patches: Sequence[Mask],
    recorder: StageRecorder,
) -> Iterator[Floats]:
    """Surfaces that have the lengths of a metric, or nearly, and differ in what is a bump and what a dent.

    Parameters
    ----------
    metric : PolyhedralMetric
        Of mean edge length 1 or so.
    system : LengthSystem
        Of its triangulation.
    energy : RegularizedEnergy
        Of the metric, about a surface nearby.
    surface : ndarray, shape (V, 3)
        Has these lengths, or nearly; it is not brought to the lengths again.
    patches : sequence of ndarray of bool, shape (V,)
        Disjoint, such as `isoembed.metric.dents.dents`.
    recorder : StageRecorder
        Counts Gauss-Newton steps and factorizations.

    Yields
    ------
    ndarray, shape (V, 3)
        What comes of one choice after the other, the most promising first: of as many as are taken.
    """
    search = _Search(metric, system, energy, patches[: MIRROR.patches], recorder)
    realized = [(NONE, surface)] if search.is_realized(surface) else []
    for begun in search.promising(search.begun(NONE, surface)):
        found = search.finished(begun)
        yield found
        if search.is_realized(found):
            realized.append((begun.choice, found))
            break
    failures = 0
    for choice, found in realized:  # it grows
        for other in search.flips(choice):
            if failures == MIRROR.failures or len(search.finished_choices) == MIRROR.finished:
                return
            if other in search.finished_choices:
                continue
            neighbor = search.finished(search.begun(other, found, choice))
            yield neighbor
            if search.is_realized(neighbor):
                realized.append((other, neighbor))
            else:
                failures += 1


@dataclass(frozen=True, eq=False)
class _Begun:
    """A choice after the first steps."""

    choice: Choice
    surface: Floats
    energy: float


def _by_energy(begun: _Begun) -> float:
    return begun.energy


class _Search:
    """The search among the choices of one metric."""

    def __init__(
        self,
        metric: PolyhedralMetric,
        system: LengthSystem,
        energy: RegularizedEnergy,
        patches: Sequence[Mask],
        recorder: StageRecorder,
    ) -> None:
        self.metric, self.system, self.energy, self.recorder = metric, system, energy, recorder
        laplacian = cotangent_laplacian(GluedMetric.of(metric), least=MIRROR.smallest_cotangent)
        self.patches = [HarmonicPatch.of(csr_array(laplacian), patch) for patch in patches]
        self.finished_choices = {NONE}

    def is_realized(self, surface: Floats) -> bool:
        """Whether a surface has the lengths."""
        r = length_residuals(self.metric.triangulation, surface, self.metric.lengths, self.metric.space)
        return bool(np.abs(r).max() <= MIRROR.exact * self.energy.unit)

    def flips(self, choice: Choice) -> Iterator[Choice]:
        """The choices that differ in one patch."""
        return (choice ^ {k} for k in range(len(self.patches)))

    def begun(self, choice: Choice, surface: Floats, reflected: Choice = NONE) -> _Begun:
        """The first steps of a choice from a surface where others are reflected."""
        lengths, unit = self.metric.lengths, self.energy.unit
        for k in choice ^ reflected:
            surface = self.patches[k].reflected(self.metric.faces, surface)
        for mu in MIRROR.weights:
            surface = self.energy.relaxed(surface, lengths, mu * unit**2, 0.0, self.recorder)
        r, pull = self.energy.residuals(surface, lengths), self.energy.roughness(surface, 0.0)
        value = float(r @ r + MIRROR.weights[-1] * unit**2 * np.sum(surface * pull))
        return _Begun(choice, surface, value)

    def promising(self, given: _Begun) -> Iterator[_Begun]:
        """Choices with less energy than the given one: of all patches, and where a descent ends."""
        every = self.begun(Choice(range(len(self.patches))), given.surface)
        begun = {given.choice: given, every.choice: every}
        best = min(given, every, key=_by_energy)
        if best is every:
            yield every
        while True:
            for choice in self.flips(best.choice):
                if choice not in begun:
                    begun[choice] = self.begun(choice, given.surface)
            lower = [
                flip for flip in map(begun.__getitem__, self.flips(best.choice)) if flip.energy < best.energy
            ]
            if not lower:
                break
            together = best.choice ^ NONE.union(*(flip.choice ^ best.choice for flip in lower))
            if together not in begun:
                begun[together] = self.begun(together, given.surface)
            best = min(*lower, begun[together], key=_by_energy)
        if best.choice not in self.finished_choices:
            yield best

    def finished(self, begun: _Begun) -> Floats:
        """Where a choice ends when mu vanishes, by Newton's method in the end."""
        self.finished_choices.add(begun.choice)
        mu = MIRROR.weights[-1] * CONTINUATION.fade * self.energy.unit**2
        finer = self.energy.finer(begun.surface)
        near, _ = let_go(finer, begun.surface, self.metric.lengths, mu, self.recorder)
        found = anneal(self.system, near, self.metric.lengths, self.recorder).vertices
        self.recorder.show(vertices=found)
        return found
