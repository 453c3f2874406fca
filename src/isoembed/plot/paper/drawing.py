"""A net on paper: what to cut, what to fold, and which sides to glue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.plot.paper.labels import Label, labels
from isoembed.plot.paper.placing import PAPERS, placed
from isoembed.plot.paper.tabs import tabs

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

NOTE = 3.0  # mm, the size of the line at the foot
LEAST = 1e-3  # radians; nobody folds by less


@dataclass(frozen=True, eq=False)
class Drawing:
    """Lines and numbers on pages below one another, in mm from the upper left corner, y upward.

    Attributes
    ----------
    width, height : float
        Of a page.
    pages : int
    cuts : list of ndarray, shape (n, 2)
        Closed outlines, with their tabs.
    mountains, valleys : list of ndarray, shape (2, 2)
        Folds away from whoever sees the outside of the solid, and toward them.
    labels : list of Label
    notes : list of Label
        A line at the foot of each page.
    """

    width: float
    height: float
    pages: int
    cuts: list[Floats]
    mountains: list[Floats]
    valleys: list[Floats]
    labels: list[Label]
    notes: list[Label]


def drawn(unfolding: Unfolding, *, paper: str = "A4", scale: float | None = None) -> Drawing:
    """Draw a net.

    Parameters
    ----------
    unfolding : Unfolding
    paper : str
        One of `isoembed.plot.paper.placing.PAPERS`.
    scale : float, optional
        Millimeters a unit of the solid; by default the largest with which each sheet fits on a page.

    Raises
    ------
    InvalidParameter
        There is no such paper, or a sheet does not fit on it.
    """
    places, pages, scale = placed(unfolding.sheets, paper, scale)
    outlines = [place.put(sheet) for place, sheet in zip(places, unfolding.sheets, strict=True)]
    angles = [some[np.abs(some) > LEAST] for some in unfolding.angles]
    folds = [
        place.put(some[np.abs(bent) > LEAST])
        for place, some, bent in zip(places, unfolding.folds, unfolding.angles, strict=True)
    ]
    standing = tabs(outlines, unfolding.sides)
    cuts, mountains, valleys = [], [], []
    for p, (outline, inside, bent) in enumerate(zip(outlines, folds, angles, strict=True)):
        around: list[Floats] = []
        for k, corner in enumerate(outline):
            around.append(corner)
            if (p, k) in standing:
                around += list(standing[p, k])
                mountains.append(outline[[k, (k + 1) % len(outline)]])
        cuts.append(np.array(around))
        mountains += list(inside[bent > 0])
        valleys += list(inside[bent < 0])
    width, height = PAPERS[paper]
    middle, foot = width / 2, height - 2 * NOTE
    notes = [
        Label(_note(scale, k + 1, pages, bool(valleys)), middle, -k * height - foot, 0.0, NOTE)
        for k in range(pages)
    ]
    numbers = labels(outlines, folds, unfolding.sides)
    return Drawing(width, height, pages, cuts, mountains, valleys, numbers, notes)


def _note(scale: float, page: int, pages: int, both: bool) -> str:
    of = f", page {page} of {pages}" if pages > 1 else ""
    folds = "dashed: fold back; dash-dotted: fold up" if both else "dashed: fold back"
    return f"outside of the solid{of}; {scale:.4g} mm a unit; {folds}"
