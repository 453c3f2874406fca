"""Polygons of any size as flat arrays of corners."""

from itertools import pairwise
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric


def next_corners(sizes: Indices) -> Indices:
    """Position in the table of the next corner around each polygon, shape (n,)."""
    ends = np.cumsum(sizes)
    after = np.arange(1, int(sizes.sum()) + 1)
    after[ends - 1] = ends - sizes
    return after


def polygon_normals(points: Floats, sizes: Indices) -> Floats:
    """Vector areas of polygons in space, times two, shape (F, 3).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Corners of the polygons.
    sizes : ndarray of int, shape (F,)
        Number of corners of each polygon.
    """
    starts = np.cumsum(sizes) - sizes
    arms = points - np.repeat(points[starts], sizes, axis=0)
    return cast(Floats, np.add.reduceat(np.cross(arms, arms[next_corners(sizes)]), starts))


def polygons_of_cells(cells: Indices) -> Indices | list[Indices]:
    """Polygons of a VTK cell list, in which the number of corners precedes the corners of each cell.

    The result is a table, shape (F, n), if all have equally many corners.

    Raises
    ------
    InvalidMetric
        A number of corners is invalid, or the list ends before the last corner.
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
