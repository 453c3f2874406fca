"""Polygons of any size as flat arrays of corners."""

from itertools import pairwise
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric


def next_corners(sizes: Indices) -> Indices:
    """The place in the table of the corner after each one around its polygon, shape (n,)."""
    ends = np.cumsum(sizes)
    after = np.arange(1, int(sizes.sum()) + 1)
    after[ends - 1] = ends - sizes
    return after


def polygon_normals(points: Floats, sizes: Indices) -> Floats:
    """Normals of polygons in space, as long as twice the areas of their projections, shape (F, 3).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The corners.
    sizes : ndarray of int, shape (F,)
        How many each polygon has.
    """
    starts = np.cumsum(sizes) - sizes
    arms = points - np.repeat(points[starts], sizes, axis=0)
    return cast(Floats, np.add.reduceat(np.cross(arms, arms[next_corners(sizes)]), starts))


def polygons_of_cells(cells: Indices) -> Indices | list[Indices]:
    """Polygons of a list in which each one's number of corners stands before them, as of VTK.

    A table, shape (F, n), if all have as many.

    Raises
    ------
    InvalidMetric
        Where a number of corners should be is none, or the list ends before the last corner.
    """
    if not len(cells):
        return np.empty((0, 3), dtype=np.int64)
    n = int(cells[0])
    if n > 0 and len(cells) % (n + 1) == 0 and (cells[:: n + 1] == n).all():
        return cells.reshape(-1, n + 1)[:, 1:]
    heads = [0]
    while heads[-1] < len(cells):
        count = int(cells[heads[-1]])
        if not 0 < count < len(cells) - heads[-1]:
            raise InvalidMetric(f"face {len(heads) - 1} has {count} corners, of {len(cells)} numbers in all")
        heads.append(heads[-1] + 1 + count)
    return [cells[head + 1 : end] for head, end in pairwise(heads)]
