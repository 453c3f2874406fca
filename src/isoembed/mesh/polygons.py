"""Polygons of any sizes as one table of corners, one polygon after the other."""

from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices


def next_corners(sizes: Indices) -> Indices:
    """The place in the table of the corner after each one around its polygon, shape (n,)."""
    ends = np.cumsum(sizes)
    after = np.arange(1, int(ends[-1]) + 1)
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
