"""Packing of sheets on pages: rotation, common scale, rows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "letter": (215.9, 279.4)}  # mm
MARGIN = 14.0  # mm, around the sheets; tabs stand out into it
FOOT = 10.0  # mm, below them and their tabs, for the ruler and the legend
GAP = 14.0  # mm, between sheets, for the tabs of both


@dataclass(frozen=True, eq=False)
class Placing:
    """Where a sheet lies: in mm from the upper left corner, y upward; the pages are below one another.

    Attributes
    ----------
    turn : ndarray, shape (2, 2)
    shift : ndarray, shape (2,)
    """

    turn: Floats
    shift: Floats

    def put(self, points: Floats) -> Floats:
        """Points of the sheet on the paper."""
        return points @ self.turn + self.shift


def placed(
    sheets: Sequence[Floats], paper: str = "A4", scale: float | None = None
) -> tuple[list[Placing], int, float]:
    """Put sheets on pages.

    Parameters
    ----------
    sheets : sequence of ndarray, shape (n, 2)
        The outlines.
    paper : str
        One of `PAPERS`.
    scale : float, optional
        Millimeters a unit of the outlines; by default the largest with which each fits on a page.

    Returns
    -------
    list of Placing
    int
        Number of pages.
    float
        The scale.

    Raises
    ------
    InvalidParameter
        There is no such paper, or a sheet does not fit on it.
    """
    if paper not in PAPERS:
        raise InvalidParameter(f"paper is {paper!r}, not one of {', '.join(PAPERS)}")
    if scale is not None and not 0 < scale < np.inf:
        raise InvalidParameter(f"scale is {scale!r}, not a positive finite number of mm")
    width, height = PAPERS[paper]
    room = np.array([width, height - FOOT]) - 2 * MARGIN
    turns = [_turned(sheet, room) for sheet in sheets]
    sizes = [np.ptp(sheet @ turn, axis=0) for sheet, turn in zip(sheets, turns, strict=True)]
    largest = [float((room / size).min()) for size in sizes]
    scale = min(largest) if scale is None else scale
    for p, most in enumerate(largest):
        if scale > most * (1 + 1e-9):
            raise InvalidParameter(
                f"scale is {scale:.6g} mm, but sheet {p} fits on {paper} up to {most:.6g} mm"
            )
    corners = np.zeros((len(sheets), 2))
    pages = np.zeros(len(sheets), dtype=np.int64)
    x = y = shelf = 0.0
    page = 0
    for p in sorted(range(len(sheets)), key=lambda p: -float(sizes[p][1])):
        across, up = scale * sizes[p]
        if x and x + across > room[0]:
            x, y, shelf = 0.0, y + shelf + GAP, 0.0
        if y and y + up > room[1]:
            x, y, shelf, page = 0.0, 0.0, 0.0, page + 1
        corners[p], pages[p] = (x, y), page
        x, shelf = x + across + GAP, max(shelf, up)
    for k in range(page + 1):  # to the middle
        mine = np.flatnonzero(pages == k)
        used = (corners[mine] + scale * np.array(sizes)[mine]).max(axis=0)
        corners[mine] += MARGIN + (room - used) / 2 + [0, k * height]
    placings = []
    for sheet, turn, (left, top) in zip(sheets, turns, corners.tolist(), strict=True):
        there = scale * sheet @ turn
        placings.append(Placing(scale * turn, np.array([left - there[:, 0].min(), -top - there[:, 1].max()])))
    return placings, page + 1, scale


def _turned(sheet: Floats, room: Floats) -> Floats:
    """How to turn a sheet so that it fits best: one side of its hull is upright or level."""
    from scipy.spatial import ConvexHull  # slow to import

    size = np.ptp(sheet, axis=0).max()
    hull = sheet[ConvexHull((sheet - sheet[0]) / size).vertices] / size
    sides = np.roll(hull, -1, axis=0) - hull
    angles = np.arctan2(sides[:, 1], sides[:, 0])
    turns = []
    for angle in np.concatenate([angles, angles + np.pi / 2]):
        cosine, sine = np.cos(angle), np.sin(angle)
        turns.append(np.array([[cosine, -sine], [sine, cosine]]))
    return max(turns, key=lambda turn: round(float((room / np.ptp(hull @ turn, axis=0)).min()), 9))
