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
from isoembed.gluing.polygon import Polygon, following, interior_angles
from isoembed.gluing.runs import Run, cut, slack
from isoembed.gluing.tolerance import ROUNDING, Tolerance

Term = tuple[int, int, float]
"""Polygon, side, and signed fraction of the side's length in a sum."""


@dataclass(frozen=True)
class Correction:
    """Displacement of the corners that made glued sides equal.

    Attributes
    ----------
    largest : float
        Largest displacement of a corner, in the unit of the sheets.
    rms : float
        Root mean square displacement over all corners.
    polygon, corner : int
        Corner with the largest displacement, in the given order.
    difference : float
        Largest difference of two glued lengths before the correction.
    source : str
        Tolerance and its origin.
    flattened : int
        Number of vertices whose total angle was corrected to 2 pi.
    largest_deficit : float
        Largest absolute deficit among them before the correction, in radians.
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
        flat = f"; {self.flattened} vertices are flattened, with deficits of up to {self.largest_deficit:.2g}"
        return (
            f"glued sides differ by up to {self.difference:.2g} (tolerance {self.source}): the sheets are "
            f"corrected, corner {self.corner} of polygon {self.polygon} most, by {self.largest:.2g}, "
            f"root mean square {self.rms:.2g}{flat if self.flattened else ''}"
        )


def corrected(
    sheets: Sequence[Polygon], runs: Sequence[tuple[Run, Run]], tolerance: Tolerance, any_surface: bool
) -> tuple[list[Polygon], Correction | None]:
    """Make glued lengths equal by the smallest displacements of the corners, in the sense of least squares.

    Vertices whose total angle is 2 pi within the errors of the corners become flat.

    Parameters
    ----------
    sheets : sequence of Polygon
        Planar polygons; others are returned unchanged.
    runs : sequence of pairs of Run
        Glued runs, of equal length within the tolerance.
    tolerance : Tolerance
    any_surface : bool
        Whether a boundary and handles are permitted.

    Returns
    -------
    list of Polygon
    Correction or None
        None if only rounding errors had to be corrected.

    Raises
    ------
    InvalidMetric
        No small displacement makes the lengths equal, or a corrected polygon intersects itself.
    """
    if not sheets[0].space.is_euclidean:
        return list(sheets), None
    size = max(float(np.ptp(sheet.corners, axis=0).max()) for sheet in sheets)
    first = np.cumsum([0, *(sheet.n for sheet in sheets)])
    after = following(first)
    start = np.concatenate([sheet.corners for sheet in sheets]) / size
    sides = _Sides.of(_equations(runs, tolerance), first, after)
    differences = np.abs(sides.values(start)) * size
    largest = float(differences.max(initial=0.0))
    rounded = ROUNDING * sum(sheet.perimeter for sheet in sheets)
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
    """Signed sums of side lengths required to vanish; each array, shape (n,), has one entry per term."""

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
        """Rows, points, and derivatives with respect to the points, (m, 2)."""
        steps = points[self.ends] - points[self.begins]
        units = self.parts[:, None] * steps / np.linalg.norm(steps, axis=1)[:, None]
        return (
            np.tile(self.rows, 2),
            np.concatenate([self.ends, self.begins]),
            np.concatenate([units, -units]),
        )


@dataclass(frozen=True, eq=False)
class _Flat:
    """Vertices whose angles must sum to 2 pi, as corners with their neighbors on the outline, shape (n,)."""

    rows: Indices
    corners: Indices
    before: Indices
    after: Indices
    straight: Floats  # contributions of points inside sides, radians
    weights: Floats  # lengths, which give all equations the same dimension

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
    """Signed sums of lengths that vanish if glued corners coincide."""
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
    """Terms of the side pieces between positions along a run, each within one side."""
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
    """Vertices that are flat within the errors of the corners, given per polygon."""
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
    flat[vertices[mates == np.arange(len(mates))]] = False  # boundary vertices
    number = np.cumsum(flat) - 1
    kept = flat[of_corner]
    count = np.bincount(of_corner, minlength=n)
    weights = count / np.maximum(np.bincount(of_corner, inverse, minlength=n), np.finfo(float).tiny)
    return _Flat(
        number[of_corner[kept]], corners[kept], before[kept], following[kept], straight[flat], weights[flat]
    )


def _nearest(start: Floats, sides: _Sides, flat: _Flat) -> Floats:
    """Nearest points at which both systems of equations vanish."""
    shape = sides.n + len(flat.straight), 2 * len(start)
    points, smallest, best = start, np.inf, start
    for _ in range(50):  # Newton steps; five are usual
        values = np.concatenate([sides.values(points), flat.values(points)])
        error = float(np.abs(values).max(initial=0.0))
        if error >= smallest / 2:
            break
        smallest, best = error, points
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
    if smallest > 1e-13:  # rounding, relative to the size of the largest sheet
        raise InvalidMetric(
            f"no small change of the polygons makes all glued sides equal: a difference of {smallest:.2g} "
            "of the size of the largest remains"
        )
    return best


def _angles(points: Floats, before: Indices, corners: Indices, after: Indices) -> Floats:
    """Interior angles in radians."""
    return interior_angles(points[after] - points[corners], points[before] - points[corners])


def _turned(vectors: Floats) -> Floats:
    """Rotate vectors by a right angle, counterclockwise."""
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])
