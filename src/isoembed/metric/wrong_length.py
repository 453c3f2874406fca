"""Identification of a wrong edge length, and estimate of the right one, from inequalities and deficits.

If one length is wrong, its edge is in all triangles that break the inequality, and the other sides of its
triangles leave it an interval.  Of several such edges it is probably the one that, with another length, has
angle deficits at the corners of its triangles nearest to those of their neighbors, as on a smooth surface.
That length is an estimate of the right one, and may show the slip: a misplaced decimal point, two exchanged
digits, a wrong digit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from typing import NamedTuple, cast

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.metric.precision import PRECISION
from isoembed.metric.triangle_checks import broken_triangles, too_large_triangles
from isoembed.metric.triangles import Triangles
from isoembed.space import Space

CLEAR = 4.0  # ratio of the misfits of other candidates to the least: 3 or more in 504 smooth and rough bodies
WITNESSES = 3  # corners, of four at most, and vertices elsewhere that have neighbors to compare them with
GRID, LEVELS = 32, 4  # lengths in the interval, in that between neighbors of the best one, ...: to 1e-5 of it
VAGUE = 0.1  # relative deviation above which an estimate tells less than the interval
SHARP = 0.02  # relative deviation above which a slip may be close to the estimate by chance
LEAST = 1e-3  # relative deviation of an estimate, however alike the deficits of a regular body are
CLOSE, APART = 2.0, 8.0  # deviations: the length that was meant is closer to the estimate, all others farther


class Candidate(NamedTuple):
    """An edge which, with another length, leaves no triangle inequality broken.

    Attributes
    ----------
    edge : int
    interval : tuple of float
        The lengths that the other sides of its triangles allow.
    misfit : float
        Mean square by which deficits at the corners of its triangles differ from those of their neighbors, at
        the estimate; NaN where there are too few neighbors.
    estimate, deviation : float
        The length with the least misfit, and its standard deviation, by misfits elsewhere or its own if this
        is larger; NaN where there are too few neighbors.
    """

    edge: int
    interval: tuple[float, float]
    misfit: float = math.nan
    estimate: float = math.nan
    deviation: float = math.nan

    @property
    def is_estimated(self) -> bool:
        """Whether the estimate tells more than the interval."""
        return self.deviation <= VAGUE * self.estimate

    def intended(self, written: float) -> float | None:
        """The length that a slip has turned into the one written, if only one is close to the estimate."""
        low, high = self.interval
        likely = {value for value in _before_slips(written) if low < value < high}
        off = sorted((abs(value - self.estimate) / self.deviation, value) for value in likely)
        alone = len(off) == 1 or (len(off) > 1 and off[1][0] > APART)
        is_sharp = self.deviation <= SHARP * self.estimate
        return off[0][1] if is_sharp and alone and off[0][0] < CLOSE else None


def wrong_length_clause(
    faces: Indices, sides: Indices, lengths: Floats, space: Space, name: Callable[[int], str]
) -> str:
    """Clause on the length that is wrong, if a single one is; empty where the lengths do not determine it.

    Parameters
    ----------
    faces, sides : ndarray of int, shape (F, 3)
        Triangles, some breaking the triangle inequality, and the index of the length of each half-edge.
    lengths : ndarray, shape (E,)
    space : Space
    name : callable
        Name of an edge in messages.
    """
    found = wrong_length(faces, sides, lengths, space)
    if found is None:
        return ""
    wrong, proved = found
    written = float(lengths[wrong.edge])
    if wrong.is_estimated:
        digits = -math.floor(math.log10(wrong.deviation))
        fits = f"about {round(wrong.estimate, digits):.9g} fits"
    else:
        low, high = wrong.interval
        fits = f"only {f'more than {low:.9g} and ' if low else ''}less than {high:.9g} is possible"
    intended = wrong.intended(written)
    return (
        f"; if one length is wrong, it is {'' if proved else 'probably '}that of {name(wrong.edge)}: "
        f"{written:.9g} where {fits}{'' if intended is None else f', probably typed for {intended:.9g}'}"
    )


def wrong_length(
    faces: Indices, sides: Indices, lengths: Floats, space: Space
) -> tuple[Candidate, bool] | None:
    """The length that is wrong, if a single one is, and whether the inequalities alone prove which it is."""
    broken = broken_triangles(sides, lengths)
    if not space.is_euclidean:
        broken |= too_large_triangles(space, lengths[sides])
    shared = set.intersection(*map(set, sides[broken].tolist()))
    if not shared:
        return None
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # sides too long for a curved space
        surface = _Surface(faces, sides, lengths, space, broken)
        candidates = [one for e in sorted(shared) if (one := surface.candidate(e))]
    if len(candidates) < 2:
        return (candidates[0], True) if candidates else None
    best, *others = sorted(candidates, key=lambda one: one.misfit)
    return (best, False) if all(one.misfit > CLEAR * best.misfit for one in others) else None


class _Surface:
    """Deficits of a metric with one wrong length, as functions of this length."""

    def __init__(self, faces: Indices, sides: Indices, lengths: Floats, space: Space, broken: Mask) -> None:
        self._faces, self._sides, self._lengths, self._space = faces, sides, lengths, space
        self._angles = np.zeros(faces.shape)
        if not broken.all():
            self._angles[~broken] = Triangles.of(lengths[sides[~broken]], space.curvature).angles
        self._ends = np.empty((len(lengths), 2), dtype=np.int64)
        self._ends[sides] = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1)
        rim = self._ends[np.bincount(sides.ravel(), minlength=len(lengths)) == 1]
        self._on_rim = np.bincount(rim.ravel(), minlength=int(faces.max()) + 1) > 0

    def candidate(self, e: int) -> Candidate | None:
        """An edge with the length that fits the deficits around it; None if its triangles allow no length."""
        beside = (self._sides == e).any(axis=1)
        low, high = self._interval(e, beside)
        if not low < high < math.inf:
            return None
        corners, at = np.unique(self._faces[beside], return_inverse=True)
        angles = np.where(beside[:, None], 0.0, self._angles)
        whole = np.where(self._on_rim, math.pi, 2 * math.pi)
        turned = np.bincount(self._faces.ravel(), angles.ravel(), minlength=len(whole))
        deficits = cast(Floats, whole - turned)
        off = deficits - self._expected(deficits, corners)
        elsewhere, usable = np.isfinite(off) & ~self._on_rim, np.isfinite(off[corners])
        elsewhere[corners] = False
        if usable.sum() < WITNESSES:
            return Candidate(e, (low, high))

        def length(turn: float) -> float:
            return low + (high - low) * math.sin(turn) ** 2

        def misfits(length: float) -> Floats:
            three = np.where(self._sides[beside] == e, length, self._lengths[self._sides[beside]])
            found = Triangles.of(three, self._space.curvature).angles
            return cast(Floats, (off[corners] - np.bincount(at.ravel(), found.ravel()))[usable])

        def square(turn: float) -> float:
            return float(np.mean(misfits(length(turn)) ** 2))

        first, last = 0.0, math.pi / 2
        for _ in range(LEVELS):
            turns = np.linspace(first, last, GRID + 2).tolist()
            misfit, k = min((square(turns[k]), k) for k in range(1, GRID + 1))
            first, estimate, last = turns[k - 1], length(turns[k]), turns[k + 1]
        step = 1e-3 * min(estimate - low, high - estimate)
        rate = np.linalg.norm(misfits(estimate + step) - misfits(estimate - step)) / (2 * step)
        squares = off[elsewhere] ** 2
        error = math.sqrt(max(squares.mean(), misfit)) if len(squares) >= WITNESSES else math.inf
        return Candidate(e, (low, high), misfit, estimate, max(float(error / rate), LEAST * estimate))

    def _interval(self, e: int, beside: Mask) -> tuple[float, float]:
        """The lengths of an edge for which its triangles exist; the first is larger if there are none."""
        low, high = 0.0, math.inf
        for three in self._sides[beside]:
            p, q = self._lengths[three[three != e]].tolist()
            low, high = max(low, abs(p - q)), min(high, p + q)
            if self._space.curvature > 0:
                high = min(high, 2 * math.pi * self._space.radius - p - q)
        return low, high

    def _expected(self, deficits: Floats, corners: Indices) -> Floats:
        """Means of the deficits of neighbors other than these corners; NaN where there are none.

        Deficits on the boundary are exterior angles, and compared with one another.
        """
        a, b = np.concatenate([self._ends, self._ends[:, ::-1]]).T
        alike = (self._on_rim[a] == self._on_rim[b]) & ~np.isin(b, corners)
        count = np.bincount(a[alike], minlength=len(deficits))
        total = np.bincount(a[alike], deficits[b[alike]], minlength=len(deficits))
        return np.divide(total, count, out=np.full(len(deficits), math.nan), where=count > 0)


def _before_slips(written: float) -> Iterator[float]:
    """Lengths that a misplaced point, two exchanged digits or a wrong digit turn into the one written."""
    _, digits, exponent = Decimal(repr(written)).as_tuple()
    assert isinstance(exponent, int)

    def value(some: Sequence[int], shift: int = 0) -> float:
        return float(Decimal((0, tuple(some), exponent + shift)))

    for shift in (-2, -1, 1, 2):
        yield value(digits, shift)
    if len(digits) > PRECISION.most:  # computed, not typed
        return
    for k, digit in enumerate(digits):
        for other in set(range(10)) - {digit}:
            yield value((*digits[:k], other, *digits[k + 1 :]))
        yield value((*digits[:k], *digits[k : k + 2][::-1], *digits[k + 2 :]))
