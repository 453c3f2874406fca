"""Predicted motions from a realization to nearby ones, from soft modes and the second-order expansion.

If x + d has the lengths of x, then ``J d + 1/2 Q(d, d) = 0`` (`length_expansion`): d is a fixed point of

    ``d -> -1/2 J^+ Q(d, d)``,

up to a factor an eigenvector of the tensor ``J^+ Q``, and the nearer it is, the larger its eigenvalue.  So
power iteration finds the near ones (as De Lathauwer, De Moor and Vandewalle, SIAM J. Matrix Anal. Appl. 21
(2000) 1324, do for the largest).  It starts at each vertex, moved alone: ``Q(d, d)`` is then 1 / l on its
edges, whatever the direction.  The motions with the smallest singular values of J are not always among the
nearest: where a single vertex can be pushed in, its edges are as stiff as others, but it is not far.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from isoembed.aim.length_expansion import LengthExpansion
from isoembed.arrays import Floats, Indices
from isoembed.surface.smoothness import QuinticResiduals

CHUNK = 128  # vertices whose power iteration goes at a time, which bounds the memory
MOST_MOTIONS = 40  # the nearest ones
SMOOTHER_MOTIONS = 20  # of the others, to where the surface is smoothest


@dataclass(frozen=True, eq=False)
class Motions:
    """Motions of a surface, each as long as takes it to where another realization is predicted.

    Attributes
    ----------
    motions : ndarray, shape (m, V, 3)
    reach : ndarray, shape (m,)
        How far the farthest vertex moves.
    defect : ndarray, shape (m,)
        How much the lengths change, over how much they change to first order: 0 if a realization is there.
    """

    motions: Floats
    reach: Floats
    defect: Floats

    @classmethod
    def of(cls, expansion: LengthExpansion, directions: Floats) -> Motions:
        """Motions along directions, (m, V, 3); those that are not predicted are infinite or not numbers.

        Of ``s J v + s^2 / 2 Q(v, v)``, the component along J v is zero.
        """
        rates, bends = expansion.rates(directions), expansion.bends(directions, directions)
        squares = np.einsum("me,me->m", rates, rates)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            s = -2 * squares / np.einsum("me,me->m", rates, bends)
            missed = np.linalg.norm(rates + s[:, None] / 2 * bends, axis=1) / np.sqrt(squares)
            motions = s[:, None, None] * directions
        return cls(motions, np.linalg.norm(motions, axis=2).max(axis=1), missed)

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
        """Motions that reach no farther than a distance, and end where the lengths are nearly right."""
        # A larger relative defect of lengths is not a motion.
        return self[np.flatnonzero((self.reach <= distance) & (self.defect <= 0.5))]

    def different(self) -> Motions:
        """Motions without near duplicates, of which that of least defect is kept; the nearest come first."""
        flat = self.motions.reshape(len(self.motions), self.motions[0].size if len(self.motions) else 0)
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        kept: list[int] = []
        for i in np.argsort(self.defect, kind="stable"):
            if not kept or np.abs(flat[kept] @ flat[i]).max() <= 0.9:  # cosine between motions that are one
                kept.append(int(i))
        return self[[kept[i] for i in np.argsort(self.reach[kept], kind="stable")]]

    def chosen(self, charts: QuinticResiduals, vertices: Floats) -> Motions:
        """Nearest of these sorted motions, then those of the others that smooth the surface most."""
        farther = range(MOST_MOTIONS, len(self.motions))
        expected = {i: charts.roughness(vertices + self.motions[i]) for i in farther}
        smooth = sorted(farther, key=lambda i: expected[i])[:SMOOTHER_MOTIONS]
        return self[[*range(min(MOST_MOTIONS, len(self.motions))), *smooth]]


def nearby_motions(
    expansion: LengthExpansion, softest: Floats, distance: float, charts: QuinticResiduals, hidden: int = 0
) -> Motions:
    """Motions of a surface to where other realizations are predicted: the nearest first, then the smooth.

    The more vertices, the more can be pushed in, and the farther are those that matter: of all that are not
    among the nearest, the ones are kept that make the surface smoother.

    Parameters
    ----------
    expansion : LengthExpansion
    softest : ndarray, shape (m, V, 3)
        Motions that change the lengths little, which join what is found from the single vertices.
    distance : float
        How far a vertex may move.
    charts : QuinticResiduals
        Of the surface.
    hidden : int
        How many of the softest are left out of all others: near a fold they hide them.
    """
    found = Motions.of(expansion, softest).within(distance)
    basis = np.linalg.qr(expansion.rates(softest[:hidden]).T)[0]
    for changes in _changes_about_vertices(expansion):
        for _ in range(5):  # power iteration
            met = Motions.of(expansion, expansion.motions(changes - changes @ basis @ basis.T))
            found = found.joined(met.within(distance)).different()
            met = met[np.flatnonzero(np.isfinite(met.reach) & (met.reach > 0))]
            if not len(met.reach):
                break
            changes = -expansion.bends(met.motions, met.motions) / 2
        found = found.chosen(charts, expansion.vertices)
    return found


def _changes_about_vertices(expansion: LengthExpansion) -> Iterator[Floats]:
    """``Q(d, d)`` where one vertex alone moves by 1, (m, E), for some vertices after the other."""
    t = expansion.system.triangulation
    weights = 1 / expansion.system.space.sn(expansion.lengths)
    for first in range(0, t.n_vertices, CHUNK):
        some = np.arange(first, min(first + CHUNK, t.n_vertices))
        yield weights * (t.edges[:, :, None] == some).any(axis=1).T
