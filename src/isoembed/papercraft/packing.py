"""Packing of rectangles on pages: maximal free rectangles, lowest place first (Jylanki 2010)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isoembed.arrays import Floats, Indices, Mask

Rectangle = tuple[float, float, float, float]
"""Left, top, width, height."""

SLACK = 1e-9  # relative tolerance for an exact fit


def packed(sizes: Floats, room: Floats, gap: float) -> tuple[Floats, Indices, Mask]:
    """Pack rectangles on few pages.

    Parameters
    ----------
    sizes : ndarray, shape (n, 2)
        Widths and heights; each rectangle fits on a page without rotation.
    room : ndarray, shape (2,)
        Size of a page; the height may be infinite.
    gap : float
        Smallest distance of any two rectangles.

    Returns
    -------
    corners : ndarray, shape (n, 2)
        Upper left corners, with y downward from the page's upper left corner.
    pages : ndarray of int, shape (n,)
    turned : ndarray of bool, shape (n,)
        Whether each rectangle is rotated by a right angle.
    """
    keys = (sizes[:, 1], sizes.max(axis=1), sizes.prod(axis=1), sizes[:, 0])
    tries = [
        _placed(sizes + gap, np.argsort(-key, kind="stable").tolist(), room + gap, turning)
        for turning in (False, True)
        for key in keys
    ]
    return min(tries, key=lambda one: (one[1].max(), _length(sizes, one[0], one[2], room)))


def _length(sizes: Floats, corners: Floats, turned: Mask, room: Floats) -> float:
    """Used length of a roll; 0 for pages, which have a fixed length."""
    if room[1] < np.inf:
        return 0.0
    return round(float((corners[:, 1] + np.where(turned, sizes[:, 0], sizes[:, 1])).max()), 6)


def _placed(sizes: Floats, order: Sequence[int], room: Floats, turning: bool) -> tuple[Floats, Indices, Mask]:
    corners, pages, turned = (
        np.zeros((len(sizes), 2)),
        np.zeros(len(sizes), np.int64),
        np.zeros(len(sizes), bool),
    )
    free: list[list[Rectangle]] = []
    for k in order:
        width, height = sizes[k].tolist()
        shapes = ((width, height), (height, width))[: 1 + turning]
        page = -1
        places: list[tuple[float, float, int, Rectangle]] = []
        while not places:
            page += 1
            if page == len(free):
                free.append([(0.0, 0.0, float(room[0]), float(room[1]))])
            places = [
                (y + high, x, turn, (x, y, wide, high))
                for turn, (wide, high) in enumerate(shapes)
                for x, y, across, down in free[page]
                if wide <= across * (1 + SLACK) and high <= down * (1 + SLACK)
            ]
        _, _, turn, occupied = min(places)
        free[page] = _without(free[page], occupied)
        corners[k], pages[k], turned[k] = occupied[:2], page, turn
    return corners, pages, turned


def _without(free: Sequence[Rectangle], occupied: Rectangle) -> list[Rectangle]:
    """Maximal free rectangles outside an occupied one."""
    left, top, right, bottom = occupied[0], occupied[1], occupied[0] + occupied[2], occupied[1] + occupied[3]
    found: set[Rectangle] = set()
    for x, y, wide, high in free:
        if x >= right or left >= x + wide or y >= bottom or top >= y + high:
            found.add((x, y, wide, high))
            continue
        found |= {
            one
            for one in (
                (x, y, left - x, high),
                (right, y, x + wide - right, high),
                (x, y, wide, top - y),
                (x, bottom, wide, y + high - bottom),
            )
            if one[2] > 0 and one[3] > 0
        }
    return sorted(one for one in found if not any(one != other and _is_inside(one, other) for other in found))


def _is_inside(one: Rectangle, other: Rectangle) -> bool:
    return (
        other[0] <= one[0]
        and other[1] <= one[1]
        and one[0] + one[2] <= other[0] + other[2]
        and one[1] + one[3] <= other[1] + other[3]
    )
