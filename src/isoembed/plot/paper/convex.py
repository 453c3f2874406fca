"""Convex pieces of the paper: whether one overlaps any of others."""

from collections.abc import Iterable

import numpy as np

from isoembed.arrays import Floats
from isoembed.kernel import kernel

SQUARE = 8.0  # mm


class Pieces:
    """Pieces with equally many corners, by the squares of the paper that their boxes touch.

    Parameters
    ----------
    corners : int
        Of each.
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
        """Those in the squares that the box of points touches, (n, corners, 2), some of them repeatedly."""
        there = [piece for square in _touched(points) for piece in self._squares.get(square, ())]
        return np.array(there) if there else self._none


def _touched(points: Floats) -> list[tuple[int, int]]:
    (left, low), (right, high) = points.min(axis=0) // SQUARE, points.max(axis=0) // SQUARE
    return [(i, j) for i in range(int(left), int(right) + 1) for j in range(int(low), int(high) + 1)]


@kernel
def overlaps(piece: Floats, others: Floats) -> bool:
    """Whether a convex polygon, (k, 2), meets any of others, (n, m, 2), which may be segments, with m = 2.

    Two that are apart are so across a line along a side of one of them.
    """
    apart = True
    for other in others:
        apart = apart and (_apart(piece, piece, other) or _apart(other, piece, other))
    return not apart


@kernel
def _apart(sides: Floats, one: Floats, other: Floats) -> bool:
    """Whether a line along one of these sides is between the two."""
    for k in range(len(sides)):
        a, b = sides[k - 1], sides[k]
        x, y = b[1] - a[1], a[0] - b[0]
        low, high, other_low, other_high = np.inf, -np.inf, np.inf, -np.inf
        for p in one:
            across = x * p[0] + y * p[1]
            low, high = min(low, across), max(high, across)
        for p in other:
            across = x * p[0] + y * p[1]
            other_low, other_high = min(other_low, across), max(other_high, across)
        if high < other_low or other_high < low:
            return True
    return False
