"""Least-squares correction of paper sheets: equal lengths of glued sides, flat interior vertices."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import lsqr

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.gluing.outline_points import cut_outlines, glued_points
from isoembed.gluing.polygon import Polygon
from isoembed.gluing.runs import Run, cut, slack
from isoembed.gluing.thresholds import GLUING
from isoembed.gluing.tolerance import Tolerance

Term = tuple[int, int, float]
"""A side of a polygon, and the part of it that counts, negative where it is subtracted."""


@dataclass(frozen=True)
class Correction:
    """The change of the sheets by which their glued sides became equal.

    Attributes
    ----------
    largest : float
        The farthest that a corner was moved, in the unit of the sheets.
    rms : float
        Root mean square over all corners.
    polygon, corner : int
        The corner that was moved farthest, as given.
    difference : float
        The largest difference between two lengths that were glued.
    source : str
        The tolerance that was used, and where it comes from.
    flattened : int
        Vertices whose total angle was made a full one.
    largest_deficit : float
        The largest deficit that one of them had, of either sign, radians.
    """

    largest: float
    rms: float
    polygon: int
    corner: int
    difference: float
    source: str
    flattened: int
    largest_deficit: float

    def __str__(self) -> str:
        flat = f"; {self.flattened} vertices are made flat, with deficits of up to {self.largest_deficit:.2g}"
        return (
            f"glued sides differ by up to {self.difference:.2g} (tolerance {self.source}): the sheets are "
            f"corrected, corner {self.corner} of polygon {self.polygon} most, by {self.largest:.2g}, "
            f"root mean square {self.rms:.2g}{flat if self.flattened else ''}"
        )


def corrected(
    sheets: Sequence[Polygon], runs: Sequence[tuple[Run, Run]], tolerance: Tolerance, any_surface: bool
) -> tuple[list[Polygon], Correction | None]:
    """Move the corners of sheets by the least sum of squares that makes glued lengths equal.

    Vertices whose total angle is a full one, as far as the errors of the corners tell, become flat.

    Parameters
    ----------
    sheets : sequence of Polygon
        Of the plane; others are returned as they are.
    runs : sequence of pairs of Run
        Glued lengths, equal within the tolerance.
    tolerance : Tolerance
    any_surface : bool
        Whether it may have a boundary or handles.

    Returns
    -------
    list of Polygon
    Correction or None
        None where nothing but rounding was to be corrected.

    Raises
    ------
    InvalidMetric
        No small change makes the lengths equal, or a polygon that is changed meets itself.
    """
    if not sheets[0].space.is_euclidean:
        return list(sheets), None
    size = max(float(np.ptp(sheet.corners, axis=0).max()) for sheet in sheets)
    first = np.cumsum([0, *(sheet.n for sheet in sheets)])
    after = np.arange(1, first[-1] + 1)
    after[first[1:] - 1] = first[:-1]
    start = np.concatenate([sheet.corners for sheet in sheets]) / size
    sides = _Sides.of(_equations(runs, tolerance), first, after)
    differences = np.abs(sides.values(start)) * size
    largest = float(differences.max(initial=0.0))
    rounded = GLUING.rounding * sum(sheet.perimeter for sheet in sheets)
    if largest <= rounded and not tolerance.units.any():
        return list(sheets), None
    errors = tolerance.errors(largest) / size
    flat = _flat_vertices(sheets, runs, tolerance, (first, after, start), errors, any_surface)
    points = _nearest(start, sides, flat)
    moved = np.linalg.norm(points - start, axis=1) * size
    worst = int(np.argmax(moved))
    p = int(np.searchsorted(first, worst, side="right")) - 1
    result = [sheet.moved_to(size * points[first[k] : first[k + 1]], k) for k, sheet in enumerate(sheets)]
    if moved[worst] <= rounded:
        return list(sheets), None
    k = worst - int(first[p])
    allowed = max(slack(one, other, tolerance) for one, other in runs)
    return result, Correction(
        float(moved[worst]),
        float(np.sqrt(np.mean(moved**2))),
        p,
        int(-k % sheets[p].n if sheets[p].turned else k),
        largest,
        f"{allowed:.2g}, {tolerance.source}",
        len(flat.weights),
        float(np.abs(flat.values(start) / flat.weights).max(initial=0.0)),
    )


@dataclass(frozen=True, eq=False)
class _Sides:
    """Sums of lengths of sides that are to vanish: an entry for each side in each, shape (n,)."""

    rows: Indices
    begins: Indices
    ends: Indices
    parts: Floats

    @classmethod
    def of(cls, equations: Sequence[Sequence[Term]], first: Indices, after: Indices) -> _Sides:
        rows = [row for row, terms in enumerate(equations) for _ in terms]
        begins = np.array([first[p] + k for terms in equations for p, k, _ in terms], dtype=np.int64)
        parts = [part for terms in equations for *_, part in terms]
        return cls(np.array(rows, dtype=np.int64), begins, after[begins], np.array(parts))

    @property
    def n(self) -> int:
        return int(self.rows.max(initial=-1)) + 1

    def values(self, points: Floats) -> Floats:
        lengths = np.linalg.norm(points[self.ends] - points[self.begins], axis=1)
        return cast(Floats, np.bincount(self.rows, self.parts * lengths, minlength=self.n))

    def gradients(self, points: Floats) -> tuple[Indices, Indices, Floats]:
        """Rows, points and derivatives with respect to these, (m, 2)."""
        steps = points[self.ends] - points[self.begins]
        units = self.parts[:, None] * steps / np.linalg.norm(steps, axis=1)[:, None]
        return (
            np.tile(self.rows, 2),
            np.concatenate([self.ends, self.begins]),
            np.concatenate([units, -units]),
        )


@dataclass(frozen=True, eq=False)
class _Flat:
    """Vertices whose angles are to sum to 2 pi: their corners, with those before and after, shape (n,)."""

    rows: Indices
    corners: Indices
    before: Indices
    after: Indices
    straight: Floats  # what points within sides contribute to each, radians
    weights: Floats  # lengths, so that equations are of one size

    def values(self, points: Floats) -> Floats:
        angles = _angles(points, self.before, self.corners, self.after)
        total = np.bincount(self.rows, angles, minlength=len(self.straight))
        return self.weights * (total + self.straight - 2 * np.pi)

    def gradients(self, points: Floats) -> tuple[Indices, Indices, Floats]:
        """See `_Sides.gradients`."""
        back, forth = points[self.before] - points[self.corners], points[self.after] - points[self.corners]
        weights = self.weights[self.rows][:, None]
        at_before = weights * _turned(back) / (back**2).sum(axis=1)[:, None]
        at_after = -weights * _turned(forth) / (forth**2).sum(axis=1)[:, None]
        return (
            np.tile(self.rows, 3),
            np.concatenate([self.before, self.after, self.corners]),
            np.concatenate([at_before, at_after, -at_before - at_after]),
        )


def _equations(runs: Sequence[tuple[Run, Run]], tolerance: Tolerance) -> list[list[Term]]:
    """Sums of lengths that vanish where the corners that meet do."""
    equations = []
    for one, other in runs:
        ours, theirs = cut(one, other, tolerance)
        folded = one.stop == other.start and one.name == other.name
        last = 0
        for k in range(1, len(ours)):
            end = k == len(ours) - 1
            if (ours[k] % 1 == 0 and theirs[k] % 1 == 0) or (end and not folded):
                terms = [
                    *_terms(one, ours[last : k + 1], 1.0),
                    *_terms(other, theirs[last : k + 1][::-1], -1.0),
                ]
                equations.append(terms)
                last = k
    return equations


def _terms(run: Run, positions: Sequence[float], sign: float) -> list[Term]:
    """The parts of sides between positions along a run, each within a side."""
    terms = []
    for a, b in itertools.pairwise(positions):
        k = int(a)
        terms.append((run.polygon, k, sign * ((b if b > a else run.sheet.n) - a)))
    return terms


def _flat_vertices(
    sheets: Sequence[Polygon],
    runs: Sequence[tuple[Run, Run]],
    tolerance: Tolerance,
    outlines: tuple[Indices, Indices, Floats],
    errors: Floats,
    any_surface: bool,
) -> _Flat:
    """The vertices that are flat if corners are off by no more than the errors, by polygon."""
    first, after, points = outlines
    stops, mates = cut_outlines(sheets, runs, tolerance)
    starts = np.cumsum([0, *map(len, stops)])
    whole = np.concatenate(stops)
    owners = np.repeat(np.arange(len(sheets)), np.diff(starts))
    at_corner = np.flatnonzero(whole % 1 == 0)
    vertices = glued_points(starts, mates, at_corner, any_surface)
    corners = first[owners[at_corner]] + whole[at_corner].astype(np.int64)
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    before, following = before[corners], after[corners]
    n = int(vertices.max()) + 1
    straight = np.pi * np.bincount(vertices[whole % 1 != 0], minlength=n)
    of_corner = vertices[at_corner]
    total = straight + np.bincount(of_corner, _angles(points, before, corners, following), minlength=n)
    inverse = sum(1 / np.linalg.norm(points[end] - points[corners], axis=1) for end in (before, following))
    off = np.bincount(of_corner, np.sqrt(2) * errors[owners[at_corner]] * inverse, minlength=n)
    flat = (np.abs(total - 2 * np.pi) <= off) & (off > 0)
    flat[vertices[mates == np.arange(len(mates))]] = False  # on a boundary
    number = np.cumsum(flat) - 1
    kept = flat[of_corner]
    count = np.bincount(of_corner, minlength=n)
    weights = count / np.maximum(np.bincount(of_corner, inverse, minlength=n), np.finfo(float).tiny)
    return _Flat(
        number[of_corner[kept]], corners[kept], before[kept], following[kept], straight[flat], weights[flat]
    )


def _nearest(start: Floats, sides: _Sides, flat: _Flat) -> Floats:
    """The points nearest to these at which both vanish."""
    shape = sides.n + len(flat.straight), 2 * len(start)
    points, least, best = start, np.inf, start
    for _ in range(50):  # Newton steps; five are usual
        values = np.concatenate([sides.values(points), flat.values(points)])
        error = float(np.abs(values).max(initial=0.0))
        if error >= least / 2:
            break
        least, best = error, points
        some, others = sides.gradients(points), flat.gradients(points)
        rows = np.concatenate([some[0], sides.n + others[0]])
        columns = 2 * np.concatenate([some[1], others[1]])
        entries = np.concatenate([some[2], others[2]])
        jacobian = csr_array(
            (
                entries.T.ravel(),
                (np.tile(rows, 2), np.concatenate([columns, columns + 1])),
            ),
            shape=shape,
        )
        wanted = jacobian @ (points - start).ravel() - values
        step = lsqr(jacobian, wanted, atol=1e-15, btol=1e-15, iter_lim=8 * max(shape))[0]
        points = start + step.reshape(-1, 2)
    if least > 1e-13:  # sizes of the largest sheet: rounding
        raise InvalidMetric(
            "no small change of the polygons makes all sides that are glued equal: a difference of "
            f"{least:.2g} of the size of the largest remains"
        )
    return best


def _angles(points: Floats, before: Indices, corners: Indices, after: Indices) -> Floats:
    """Interior angles, radians."""
    (x, y), (u, v) = ((points[end] - points[corners]).T for end in (after, before))
    return np.arctan2(x * v - y * u, x * u + y * v) % (2 * np.pi)


def _turned(vectors: Floats) -> Floats:
    """Rotate vectors by a right angle, counterclockwise."""
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])
