"""Simple polygons as sheets of paper, and positions on their boundaries counted in corners."""

from __future__ import annotations

import numbers
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing.loops import meeting
from isoembed.mesh.triangulation import frozen
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import Model, from_model, to_model

Side = tuple[int, int]
"""Polygon and side, which runs from the corner of the same number to the next one."""


@dataclass(frozen=True, eq=False)
class Polygon:
    """A simple polygon with straight sides, counterclockwise, starting at the first given corner.

    A position on the boundary is counted in corners: 2.5 is the midpoint of side 2, which runs from corner 2
    to corner 3.  Positions are periodic.

    Attributes
    ----------
    corners : ndarray, shape (n, 2)
        Ambient coordinates: those of the plane, or the first two of the sphere or hyperboloid.
    space : Space
        Space with the curvature of the plane, sphere or hyperbolic plane that contains the polygon.
    turned : bool
        Whether the corners were given clockwise; given corner k is then ``-k % n``.
    arcs : ndarray, shape (n + 1,)
        Arc length from corner 0 to each corner, and the perimeter.
    """

    corners: Floats
    space: Space
    turned: bool
    arcs: Floats

    @classmethod
    def of(cls, points: ArrayLike, index: int, space: Space = EUCLIDEAN, model: Model = "ambient") -> Polygon:
        """Polygon with given corners in either orientation, checked.

        Parameters
        ----------
        points : array_like of float, shape (n, 2)
            Corners; consecutive sides may be collinear.
        index : int
            Index of the polygon, for messages.
        space : Space
            Space with the curvature of the polygon's plane.
        model : {"ambient", "conformal", "projective"}
            Coordinates of the corners if the space is curved.

        Raises
        ------
        InvalidMetric
            The polygon has fewer than three corners, an invalid corner, a side of length zero, or
            self-intersections.
        """
        corners = points_of_the_plane(points, f"polygon {index}").copy()
        try:
            corners = from_model(space, corners, model)
        except InvalidParameter as error:
            raise InvalidMetric(f"polygon {index}: {error}") from None
        if len(corners) < 3:
            raise InvalidMetric(f"polygon {index} has {len(corners)} corners: it takes 3")
        same = (corners == np.roll(corners, -1, axis=0)).all(axis=1)
        if same.any():
            k = int(np.argmax(same))
            raise InvalidMetric(
                f"side {k} of polygon {index} has no length: its ends are both at {corners[k].tolist()}"
            )
        turned = signed_area(_checked(corners, space, index, "not simple")) < 0
        if turned:
            corners = np.roll(corners[::-1], 1, axis=0)
        return cls._create(corners, space, turned)

    @classmethod
    def _create(cls, corners: Floats, space: Space, turned: bool) -> Polygon:
        arcs = np.concatenate([[0.0], np.cumsum(side_lengths(corners, space))])
        return cls(frozen(corners), space, turned, frozen(arcs))

    def moved_to(self, corners: Floats, index: int) -> Polygon:
        """Polygon with displaced corners, given counterclockwise; `index` is for messages.

        Raises
        ------
        InvalidMetric
            The polygon intersects itself.
        """
        _checked(corners, self.space, index, "no longer simple when corrected")
        return Polygon._create(corners.copy(), self.space, self.turned)

    def turned_over(self) -> Polygon:
        """Mirror image of the polygon, with the same corner 0."""
        corners = np.roll((self.corners * [-1.0, 1.0])[::-1], 1, axis=0)
        return Polygon._create(corners, self.space, not self.turned)

    @property
    def n(self) -> int:
        """Number of corners."""
        return len(self.corners)

    @property
    def sides(self) -> Floats:
        """Lengths of the sides, shape (n,)."""
        return side_lengths(self.corners, self.space)

    @property
    def perimeter(self) -> float:
        """Length of the boundary."""
        return float(self.arcs[-1])

    @property
    def angles(self) -> Floats:
        """Interior angle at each corner, radians, shape (n,)."""
        return interior_angles(
            *(self.space.seen_from(self.corners, np.roll(self.corners, k, axis=0)) for k in (-1, 1))
        )

    def arc(self, position: float) -> float:
        """Arc length from corner 0 to a position in [0, n)."""
        side = int(position)
        start, end = self.arcs[side : side + 2]
        return float(start + (position - side) * (end - start))

    def position(self, arc: float) -> float:
        """Position in [0, n) at an arc length from corner 0; the inverse of `arc`."""
        arc %= self.perimeter
        side = min(int(np.searchsorted(self.arcs, arc, side="right")), self.n) - 1
        part = (arc - self.arcs[side]) / (self.arcs[side + 1] - self.arcs[side])
        return (side + float(part)) % self.n

    def points(self, positions: Floats) -> Floats:
        """Boundary points at positions in [0, n), shape (m, 2); corners are exact."""
        side = positions.astype(np.int64)
        part = (positions - side)[:, None]
        start, end = self.corners[side], self.corners[(side + 1) % self.n]
        if self.space.is_euclidean:
            return start + part * (end - start)
        lengths, sn = self.sides[side, None], self.space.sn
        between = (sn((1 - part) * lengths) * start + sn(part * lengths) * end) / sn(lengths)
        return np.where(part == 0, start, between)


def _checked(corners: Floats, space: Space, index: int, description: str) -> Floats:
    """Shape of an outline, as from `shape_of`; raises an error if it intersects itself."""
    shape = shape_of(corners, space)
    first, second = meeting_sides(shape)
    if first >= 0:
        raise InvalidMetric(
            f"polygon {index} is {description}: sides {min(first, second)} and {max(first, second)} meet"
        )
    return shape


def consecutive(ring: Sequence[int] | Indices) -> list[tuple[int, int]]:
    """Pairs of neighbors around a ring of corners, each with the next one."""
    corners = [int(corner) for corner in ring]
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def following(first: Indices) -> Indices:
    """Index of the next point around each of several rings, which are concatenated.

    Parameters
    ----------
    first : ndarray of int, shape (n + 1,)
        Index of the first point of each ring, followed by the number of points.
    """
    after = np.arange(1, first[-1] + 1)
    after[first[1:] - 1] = first[:-1]
    return after


def points_of_the_plane(coordinates: ArrayLike, name: str) -> Floats:
    """Points (n, 2), checked.

    Raises
    ------
    InvalidMetric
        A corner is not a pair of finite numbers; the message names the first.
    """
    try:
        points = np.asarray(coordinates)
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


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a real number other than a Boolean."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def segments(points: Floats) -> Floats:
    """Ends of the sides of a closed polygon, shape (n, 2, 2)."""
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def interior_angles(forth: Floats, back: Floats) -> Floats:
    """Angles in [0, 2 pi) at corners, from vectors (n, 2) to the next and to the previous one."""
    (x, y), (u, v) = forth.T, back.T
    return np.arctan2(x * v - y * u, x * u + y * v) % (2 * np.pi)


def signed_area(corners: Floats) -> float:
    """Signed area of a planar polygon (n, 2), negative if clockwise."""
    x, y = (corners - corners[0]).T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2


def side_lengths(points: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Lengths of the sides of a closed polygon, shape (n,)."""
    return distances(points, np.roll(points, -1, axis=0), space)


def distances(a: Floats, b: Floats, space: Space) -> Floats:
    """Distances between points (..., 2) of the plane, or of the sphere or hyperbolic plane."""
    if space.is_euclidean:
        return np.asarray(np.hypot(*np.moveaxis(b - a, -1, 0)))
    return space.distances(a, b)


def shape_of(points: Floats, space: Space) -> Floats:
    """Outline points in a plane in which geodesic sides are straight, scaled to size 1."""
    points = to_model(space, points, "projective")
    return (points - points.min(axis=0)) / float(np.ptp(points, axis=0).max())


def meeting_sides(points: Floats) -> tuple[int, int]:
    """Two sides of a closed polygon, of size at most 1, that meet other than at a common corner.

    Sides that fold back at a common corner count; (-1, -1) if the polygon is simple.
    """
    left_ends = np.minimum(points[:, 0], np.roll(points[:, 0], -1))
    return meeting(points, np.argsort(left_ends, kind="stable"))
