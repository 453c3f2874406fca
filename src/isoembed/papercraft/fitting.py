"""Fit of a polygon into a rectangle: best rotation and largest scale."""

from __future__ import annotations

from typing import cast

import numpy as np

from isoembed.arrays import Floats


def best_turn(points: Floats, room: Floats, *, oblique: bool = False) -> tuple[Floats, float]:
    """Rotation for which a figure fits into a rectangle at the largest scale.

    The scale is the smaller ratio of the rectangle's width and height to those of the figure.  Between two
    directions in which a side of the hull is parallel to an axis, neither ratio has a maximum, so the optimum
    is at one of these directions, or where the two ratios are equal.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    room : ndarray, shape (2,)
        Width and height; one may be infinite.
    oblique : bool, optional
        Whether to include directions in which no side of the hull is parallel to an axis.

    Returns
    -------
    turn : ndarray, shape (2, 2)
        Rotation; the rotated figure is ``points @ turn``.
    scale : float
        Largest scale.
    """
    hull, angles = _flush(points)
    if oblique:
        angles = np.concatenate([angles, _balanced(hull, angles, room)])
    turns = _turns(angles)
    scales = (room / np.ptp(hull @ turns, axis=1)).min(axis=1)
    best = int(np.argmax(scales.round(9)))
    return turns[best], float((room / np.ptp(points @ turns[best], axis=0)).min())


def compact_turn(points: Floats, room: Floats) -> Floats:
    """Rotation for which a figure fits into a rectangle and its bounding box has the smallest area.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    room : ndarray, shape (2,)
        Rectangle, into which the figure fits with a side of its hull parallel to an axis.
    """
    hull, angles = _flush(points)
    turns = _turns(angles)
    sizes = np.ptp(hull @ turns, axis=1)
    scales = (room / sizes).min(axis=1) / np.ptp(points, axis=0).max()
    areas = np.where(scales >= min(1.0, scales.max()), sizes.prod(axis=1), np.inf)
    return cast(Floats, turns[int(np.argmin(areas.round(9)))])


def _flush(points: Floats) -> tuple[Floats, Floats]:
    """Convex hull of a figure, scaled to size 1, and directions in which a side is parallel to an axis."""
    from scipy.spatial import ConvexHull  # slow to import

    size = np.ptp(points, axis=0).max()
    hull = points[ConvexHull((points - points[0]) / size).vertices] / size
    sides = np.roll(hull, -1, axis=0) - hull
    angles = np.arctan2(sides[:, 1], sides[:, 0])
    return hull, np.concatenate([angles, angles + np.pi / 2])


def _turns(angles: Floats) -> Floats:
    """Clockwise rotations by the given angles, shape (n, 2, 2)."""
    turns = np.array([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]])
    return turns.transpose(2, 0, 1)


def _balanced(hull: Floats, flush: Floats, room: Floats) -> Floats:
    """Directions in which both ratios are equal, one between any two neighboring directions of sides."""
    ends = np.unique(flush % np.pi)
    middles = (ends + np.append(ends[1:], ends[0] + np.pi)) / 2
    along = np.column_stack([np.cos(middles), np.sin(middles)])
    across = np.column_stack([-np.sin(middles), np.cos(middles)])
    wide, high = (
        hull[np.argmax(hull @ to.T, axis=0)] - hull[np.argmin(hull @ to.T, axis=0)] for to in (along, across)
    )
    share = room[0] / room[1]  # wide . (cos, sin) = share high . (-sin, cos)
    return cast(Floats, np.arctan2(share * high[:, 1] - wide[:, 0], wide[:, 1] + share * high[:, 0]))
