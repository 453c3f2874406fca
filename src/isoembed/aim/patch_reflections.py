"""Patch reflections: dents of a metric, each pushed in or out.

A path of smooth surfaces from a convex one reaches a dent through a flat spot, and may leave it on the wrong
side.  If a metric has dents (`isoembed.metric.dents`), they are made in one step: the vertices of a patch of
the convex surface are reflected in the harmonic surface spanned by its rim, a plane if the rim is plane.  A
few steps of the regularized continuation then lead to the lengths, if to any surface.

There are 2^k choices for k patches.  All are reflected first.  If that fails, choices are compared by their
energies after the first steps, and a descent, patch by patch, selects those to complete.  A choice whose
first step cannot go downhill is discarded: the convex surface is too far from the lengths.  The neighbors of
a realization, which differ in one patch, are tried next, and so on from each realization found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array

from isoembed.aim.acceptance import PLACED
from isoembed.aim.anneal import anneal
from isoembed.aim.regularized_continuation import release_penalty
from isoembed.aim.regularized_energy import LEAST_COTANGENT, RegularizedEnergy
from isoembed.arrays import Floats, Indices, Mask
from isoembed.linalg import Factor, factor_general
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.measures import vertex_normals
from isoembed.surface.rigidity import LengthSystem

WEIGHTS = (0.1, 0.01, 0.01)  # mean edge lengths^2; successive mu after a reflection
FADE = 0.3  # factor of mu between later steps


Choice = frozenset[int]
"""The reflected patches."""


@dataclass(frozen=True, eq=False)
class HarmonicPatch:
    """A patch, and the harmonic surface spanned by its rim.

    Attributes
    ----------
    inside : ndarray of int, shape (n,)
        The vertices of the patch.
    factor : Factor
        Factorization of the Laplacian among them.
    coupling : csr_array, shape (n, V)
        The Laplacian between them and all others.
    """

    inside: Indices
    factor: Factor
    coupling: csr_array

    @classmethod
    def of(cls, laplacian: csr_array, patch: Mask) -> HarmonicPatch:
        """Patch of the vertices of a mask, (V,), with the Laplacian of the metric."""
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


def reflected_realizations(
    metric: PolyhedralMetric,
    system: LengthSystem,
    energy: RegularizedEnergy,
    start: Floats,
    patches: Sequence[Mask],
    recorder: StageRecorder,
) -> Iterator[Floats]:
    """Surfaces with the lengths of a metric, or nearly, with different patches pushed in.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    system : LengthSystem
    energy : RegularizedEnergy
        Energy of the metric about the start.
    start : ndarray, shape (V, 3)
        A nearby convex surface.
    patches : sequence of ndarray of bool, shape (V,)
        Disjoint patches, as of `isoembed.metric.dents.dents`.
    recorder : StageRecorder
        Recorder of the Gauss-Newton steps.

    Yields
    ------
    ndarray, shape (V, 3)
        Surfaces of successive choices, the most promising first.
    """
    # Eight patches with the largest curvature of their caps.
    search = _Search(metric, system, energy, start, patches[:8], recorder)
    realized = []
    for choice in search.promising():
        found = search.finished(choice)
        yield found
        if search.is_realized(found):
            realized.append(choice)
            break
    failures = 0
    for choice in realized:  # it grows
        for other in search.flips(choice):
            # Two failures next to realizations, or eight completed choices, end the search.
            if failures == 2 or len(search.done) == 8:
                return
            if other in search.done:
                continue
            found = search.finished(other)
            yield found
            if search.is_realized(found):
                realized.append(other)
            else:
                failures += 1


class _Search:
    """The search among the choices of one metric.

    Attributes
    ----------
    done : set of Choice
        Completed choices.
    """

    def __init__(
        self,
        metric: PolyhedralMetric,
        system: LengthSystem,
        energy: RegularizedEnergy,
        start: Floats,
        patches: Sequence[Mask],
        recorder: StageRecorder,
    ) -> None:
        self.metric, self.system, self.energy, self.recorder = metric, system, energy, recorder
        self.start = start
        laplacian = cotangent_laplacian(GluedMetric.of(metric), least=LEAST_COTANGENT)
        self.patches = [HarmonicPatch.of(csr_array(laplacian), patch) for patch in patches]
        self.done: set[Choice] = set()
        self._begun: dict[Choice, tuple[Floats, float]] = {}

    def is_realized(self, surface: Floats) -> bool:
        """Whether a surface has the lengths."""
        r = self.energy.residuals(surface, self.metric.lengths)
        return bool(np.abs(r).max() <= PLACED * self.energy.unit)

    def flips(self, choice: Choice) -> list[Choice]:
        """The choices with one patch changed."""
        return [choice ^ {k} for k in range(len(self.patches))]

    def begun(self, choice: Choice) -> tuple[Floats, float]:
        """The surface of a choice after the first steps, and its energy, infinite for discarded choices."""
        if choice not in self._begun:
            lengths, x = self.metric.lengths, self.start
            for k in choice:
                x = self.patches[k].reflected(self.metric.faces, x)
            value = np.inf
            for weight in WEIGHTS:
                mu = weight * self.energy.unit**2
                before, x = x, self.energy.relaxed(x, lengths, mu, 0.0, self.recorder)
                if x is before:
                    break
            else:
                r = self.energy.residuals(x, lengths)
                value = float(r @ r + mu * np.sum(x * self.energy.roughness(x, 0.0)))
            self._begun[choice] = x, value
        return self._begun[choice]

    def value(self, choice: Choice) -> float:
        """The energy of a choice after the first steps."""
        return self.begun(choice)[1]

    def promising(self) -> Iterator[Choice]:
        """The choice of all patches, and the end of a descent, without discarded choices."""
        every, none = Choice(range(len(self.patches))), Choice()
        if self.value(every) < np.inf:
            yield every
        best = min(every, none, key=self.value)
        if not self.value(best) < np.inf:
            return
        while len(self._begun) < 8:  # choices compared by their energy
            lower = [flip for flip in self.flips(best) if self.value(flip) < self.value(best)]
            if not lower:
                break
            together = best ^ Choice().union(*(flip ^ best for flip in lower))
            best = min([*lower, together], key=self.value)
        if best not in self.done:
            yield best

    def finished(self, choice: Choice) -> Floats:
        """Surface of a choice in the limit of vanishing mu, completed by Newton's method."""
        self.done.add(choice)
        x, _ = self.begun(choice)
        mu = WEIGHTS[-1] * FADE * self.energy.unit**2
        near, _ = release_penalty(self.energy.finer(x), x, self.metric.lengths, mu, self.recorder, fade=FADE)
        found = anneal(self.system, near, self.metric.lengths, self.recorder).vertices
        self.recorder.show(vertices=found)
        return found
