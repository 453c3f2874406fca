"""Predicted motions from a realization to nearby ones, from soft modes and the second-order expansion.

If x + d has the lengths of x, then ``J d + 1/2 Q(d, d) = 0`` (`length_expansion`): d is a fixed point of

    ``d -> -1/2 J^+ Q(d, d)``,

up to a factor an eigenvector of the tensor ``J^+ Q``, with larger eigenvalues for shorter motions.  Power
iteration therefore finds the short ones (cf. De Lathauwer, De Moor and Vandewalle, SIAM J. Matrix Anal. Appl.
21 (2000) 1324, for the largest eigenvalue).  It starts from motions of single vertices, for which ``Q(d, d)``
is 1 / l on the adjacent edges in any direction.  The motions with the smallest singular values of J are not
always the shortest: a vertex that can be pushed in may have stiff edges and a short way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from isoembed.aim.length_expansion import LengthExpansion
from isoembed.arrays import Floats, Indices
from isoembed.surface.smoothness import QuinticResiduals

CHUNK = 128  # simultaneous power iterations, to bound the memory
MOST_MOTIONS = 40  # shortest motions kept
SMOOTHER_MOTIONS = 20  # further motions kept, to the smoothest surfaces


@dataclass(frozen=True, eq=False)
class Motions:
    """Motions of a surface to predicted realizations.

    Attributes
    ----------
    motions : ndarray, shape (m, V, 3)
    reach : ndarray, shape (m,)
        Largest displacement of a vertex.
    defect : ndarray, shape (m,)
        Norm of the change of the lengths over its first-order part; 0 at a realization.
    """

    motions: Floats
    reach: Floats
    defect: Floats

    @classmethod
    def of(cls, expansion: LengthExpansion, directions: Floats) -> Motions:
        """Motions along directions, (m, V, 3); infinite or NaN without a prediction.

        The component of ``s J v + s^2 / 2 Q(v, v)`` along J v vanishes.
        """
        rates, bends = expansion.rates(directions), expansion.bends(directions, directions)
        squares = np.einsum("me,me->m", rates, rates)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            s = -2 * squares / np.einsum("me,me->m", rates, bends)
            relative_residuals = np.linalg.norm(rates + s[:, None] / 2 * bends, axis=1) / np.sqrt(squares)
            motions = s[:, None, None] * directions
        return cls(motions, np.linalg.norm(motions, axis=2).max(axis=1), relative_residuals)

    def __getitem__(self, which: Indices | list[int]) -> Motions:
        return Motions(self.motions[which], self.reach[which], self.defect[which])

    def joined(self, others: Motions) -> Motions:
        """Concatenate two sets of motions."""
        return Motions(
            np.concatenate([self.motions, others.motions]),
            np.concatenate([self.reach, others.reach]),
            np.concatenate([self.defect, others.defect]),
        )

    def within(self, distance: float) -> Motions:
        """Motions within a distance whose lengths at the end are nearly right."""
        # Larger relative defects are discarded.
        return self[np.flatnonzero((self.reach <= distance) & (self.defect <= 0.5))]

    def different(self) -> Motions:
        """Motions without near duplicates, keeping those of least defect; the shortest come first."""
        flat = self.motions.reshape(len(self.motions), self.motions[0].size if len(self.motions) else 0)
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        selected: list[int] = []
        for i in np.argsort(self.defect, kind="stable"):
            if not selected or np.abs(flat[selected] @ flat[i]).max() <= 0.9:  # cosine of duplicates
                selected.append(int(i))
        return self[[selected[i] for i in np.argsort(self.reach[selected], kind="stable")]]

    def chosen(self, charts: QuinticResiduals, vertices: Floats) -> Motions:
        """The shortest of these sorted motions, then the others that smooth the surface most."""
        farther = range(MOST_MOTIONS, len(self.motions))
        expected = {i: charts.roughness(vertices + self.motions[i]) for i in farther}
        smooth = sorted(farther, key=lambda i: expected[i])[:SMOOTHER_MOTIONS]
        return self[[*range(min(MOST_MOTIONS, len(self.motions))), *smooth]]


def nearby_motions(
    expansion: LengthExpansion, softest: Floats, distance: float, charts: QuinticResiduals, hidden: int = 0
) -> Motions:
    """Motions of a surface to predicted realizations: the shortest first, then the smoothing ones.

    With more vertices, more of them can be pushed in, and the relevant realizations are farther.  Beyond the
    shortest motions, those that smooth the surface are kept.

    Parameters
    ----------
    expansion : LengthExpansion
    softest : ndarray, shape (m, V, 3)
        Softest motions, added to those found from single vertices.
    distance : float
        Largest displacement of a vertex.
    charts : QuinticResiduals
        Charts of the surface.
    hidden : int
        Number of softest motions projected out of all others, which they hide near a fold.
    """
    found = Motions.of(expansion, softest).within(distance)
    basis = np.linalg.qr(expansion.rates(softest[:hidden]).T)[0]
    for changes in _changes_about_vertices(expansion):
        for _ in range(5):  # power iteration
            motions = Motions.of(expansion, expansion.motions(changes - changes @ basis @ basis.T))
            found = found.joined(motions.within(distance)).different()
            motions = motions[np.flatnonzero(np.isfinite(motions.reach) & (motions.reach > 0))]
            if not len(motions.reach):
                break
            changes = -expansion.bends(motions.motions, motions.motions) / 2
        found = found.chosen(charts, expansion.vertices)
    return found


def _changes_about_vertices(expansion: LengthExpansion) -> Iterator[Floats]:
    """``Q(d, d)`` for unit displacements of single vertices, (m, E), in chunks of vertices."""
    t = expansion.system.triangulation
    weights = 1 / expansion.system.space.sn(expansion.lengths)
    for first in range(0, t.n_vertices, CHUNK):
        some = np.arange(first, min(first + CHUNK, t.n_vertices))
        yield weights * (t.edges[:, :, None] == some).any(axis=1).T
