"""Overlap tests of convex pieces of paper."""

from collections.abc import Iterable

import numpy as np

from isoembed.arrays import Floats, Mask

SQUARE = 8.0  # mm


class Pieces:
    """Pieces with equal numbers of corners, in a hash grid of the squares touched by their bounding boxes.

    Parameters
    ----------
    corners : int
        Number of corners of each piece.
    some : ndarray, shape (n, corners, 2)
    """

    def __init__(self, corners: int, some: Iterable[Floats] = ()) -> None:
        self._none = np.empty((0, corners, 2))
        self._squares: dict[tuple[int, int], list[Floats]] = {}
        for piece in some:
            self.add(piece)

    def add(self, piece: Floats) -> None:
        """Add a piece."""
        for square in _touched(piece):
            self._squares.setdefault(square, []).append(piece)

    def near(self, points: Floats) -> Floats:
        """Pieces in the squares touched by the bounding box of points, (n, corners, 2), possibly repeated."""
        there = [piece for square in _touched(points) for piece in self._squares.get(square, ())]
        return np.array(there) if there else self._none


def _touched(points: Floats) -> list[tuple[int, int]]:
    (left, low), (right, high) = points.min(axis=0) // SQUARE, points.max(axis=0) // SQUARE
    return [(i, j) for i in range(int(left), int(right) + 1) for j in range(int(low), int(high) + 1)]


def overlaps(piece: Floats, others: Floats) -> bool:
    """Whether a convex polygon, (k, 2), meets any of others, (n, m, 2), which may be segments (m = 2)."""
    return bool(overlapping(piece[None], others)[0])


def overlapping(pieces: Floats, others: Floats) -> Mask:
    """Mask of the convex polygons, (p, k, 2), that meet any of others, as in `overlaps`.

    Disjoint convex polygons are separated by a line along a side of one of them.
    """
    one, other = pieces[:, None], others[None]
    return np.asarray(~(_apart(one, one, other) | _apart(other, one, other)).all(axis=1))


def _apart(sides: Floats, one: Floats, other: Floats) -> Mask:
    """Whether a line along one of the sides separates the two; each of shape (p or 1, n or 1, corners, 2)."""
    x, y = np.moveaxis(sides - np.roll(sides, 1, axis=2), 3, 0)[..., None]
    across, beyond = (y * p[:, :, None, :, 0] - x * p[:, :, None, :, 1] for p in (one, other))
    before = across.max(axis=3) < beyond.min(axis=3)
    return (before | (beyond.max(axis=3) < across.min(axis=3))).any(axis=2)
