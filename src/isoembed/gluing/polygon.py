"""Simple polygons, the sheets of paper, and positions on their boundaries counted in corners."""

from __future__ import annotations

import numbers
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.gluing.thresholds import GLUING
from isoembed.intrinsic.plane import folds, meet
from isoembed.kernel import kernel
from isoembed.mesh.triangulation import frozen


@dataclass(frozen=True, eq=False)
class Polygon:
    """A simple polygon, counterclockwise, with corner 0 the first that was given.

    A position on the boundary is counted in corners: 2.5 is the middle of side 2, which runs from corner 2
    to corner 3.  Positions beyond the last corner go on with the first.

    Attributes
    ----------
    corners : ndarray, shape (n, 2)
    turned : bool
        The corners were given clockwise: the one called k is ``-k % n`` here.
    arcs : ndarray, shape (n + 1,)
        Length of the boundary from corner 0 to each corner, and all around.
    """

    corners: Floats
    turned: bool
    arcs: Floats

    @classmethod
    def of(cls, given: ArrayLike, index: int) -> Polygon:
        """The polygon with these corners in either orientation, checked.

        Parameters
        ----------
        given : array_like of float, shape (n, 2)
            Consecutive sides may be in line.
        index : int
            What it is called in a message.

        Raises
        ------
        InvalidMetric
            It has fewer than three corners, a corner that is no point of the plane, a side without length, or
            it meets itself.
        """
        corners = points_of_the_plane(given, f"polygon {index}").copy()
        if len(corners) < 3:
            raise InvalidMetric(f"polygon {index} has {len(corners)} corners: it takes 3")
        same = (corners == np.roll(corners, -1, axis=0)).all(axis=1)
        if same.any():
            k = int(np.argmax(same))
            raise InvalidMetric(
                f"side {k} of polygon {index} has no length: its ends are both at {corners[k].tolist()}"
            )
        shape = (corners - corners.min(axis=0)) / float(np.ptp(corners, axis=0).max())
        first, second = meeting_sides(shape)
        if first >= 0:
            raise InvalidMetric(
                f"polygon {index} is not simple: sides {min(first, second)} and {max(first, second)} meet"
            )
        x, y = shape.T
        turned = bool((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0)
        if turned:
            corners = np.roll(corners[::-1], 1, axis=0)
        steps = side_lengths(corners)
        return cls(frozen(corners), turned, frozen(np.concatenate([[0.0], np.cumsum(steps)])))

    def turned_over(self) -> Polygon:
        """The same sheet seen from its back, corner 0 the same."""
        corners = np.roll((self.corners * [-1.0, 1.0])[::-1], 1, axis=0)
        arcs = np.concatenate([[0.0], np.cumsum(side_lengths(corners))])
        return Polygon(frozen(corners), not self.turned, frozen(arcs))

    @property
    def n(self) -> int:
        """Number of corners."""
        return len(self.corners)

    @property
    def perimeter(self) -> float:
        """Length of the boundary."""
        return float(self.arcs[-1])

    @property
    def angles(self) -> Floats:
        """The interior angle at each corner, radians, shape (n,)."""
        (x, y), (u, v) = ((np.roll(self.corners, k, axis=0) - self.corners).T for k in (-1, 1))
        return np.arctan2(x * v - y * u, x * u + y * v) % (2 * np.pi)

    def arc(self, position: float) -> float:
        """Length of the boundary from corner 0 to a position from 0 to below n."""
        side = int(position)
        start, end = self.arcs[side : side + 2]
        return float(start + (position - side) * (end - start))

    def position(self, arc: float) -> float:
        """The position at this length from corner 0, the inverse of `arc`; from 0 to below n."""
        arc %= self.perimeter
        side = min(int(np.searchsorted(self.arcs, arc, side="right")), self.n) - 1
        part = (arc - self.arcs[side]) / (self.arcs[side + 1] - self.arcs[side])
        return (side + float(part)) % self.n

    def points(self, positions: Floats) -> Floats:
        """Where positions from 0 to below n lie in the plane, shape (m, 2); corners exactly."""
        side = positions.astype(np.int64)
        part = (positions - side)[:, None]
        start, end = self.corners[side], self.corners[(side + 1) % self.n]
        return start + part * (end - start)


def points_of_the_plane(given: ArrayLike, name: str) -> Floats:
    """Points (n, 2), checked.

    Raises
    ------
    InvalidMetric
        Naming the first corner that is not two finite numbers.
    """
    try:
        points = np.asarray(given)
    except ValueError:  # rows of different sizes
        points = np.empty(0, dtype=object)
    if points.ndim != 2 or points.shape[1] != 2 or points.dtype.kind not in "iuf":
        raise InvalidMetric(f"{name} is not a list of corners [x, y]")
    points = points.astype(np.float64)
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        k = int(np.argmin(finite))
        raise InvalidMetric(f"corner {k} of {name} is at {points[k].tolist()}, which is not finite")
    return points


def is_number(value: object) -> bool:
    """Whether a value is a real number, and not a truth value."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def differ(ours: float, theirs: float, sheets: tuple[Polygon, Polygon]) -> bool:
    """Whether two lengths on the outlines of two sheets are not the same, up to typing and rounding."""
    rounding = GLUING.rounding * sum(sheet.perimeter for sheet in sheets)
    return abs(ours - theirs) > GLUING.same_length * max(ours, theirs) + rounding


def side_lengths(points: Floats) -> Floats:
    """Lengths of the sides of a closed polygon, shape (n,)."""
    return np.asarray(np.hypot(*(np.roll(points, -1, axis=0) - points).T))


def meeting_sides(points: Floats) -> tuple[int, int]:
    """Two sides of a closed polygon, of the size of 1 at most, that meet elsewhere than in a common corner.

    Those that fold back there meet, too; (-1, -1) if none do, and the polygon is simple.
    """
    left_ends = np.minimum(points[:, 0], np.roll(points[:, 0], -1))
    return _meeting(points, np.argsort(left_ends, kind="stable"))


@kernel
def _meeting(points: Floats, order: Indices) -> tuple[int, int]:
    """As `meeting_sides`.

    The sides come in the order of their left ends, and each is compared with those that begin before it ends.
    """
    n = len(points)
    for k in range(n):
        i = order[k]
        a, b = points[i], points[(i + 1) % n]
        right = max(a[0], b[0])
        for m in range(k + 1, n):
            j = order[m]
            c, d = points[j], points[(j + 1) % n]
            if min(c[0], d[0]) > right:
                break
            if j == (i + 1) % n:
                if folds(a, b, d):
                    return i, j
            elif i == (j + 1) % n:
                if folds(c, d, b):
                    return i, j
            elif meet(a, b, c, d):
                return i, j
    return -1, -1
