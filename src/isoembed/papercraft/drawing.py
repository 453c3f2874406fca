"""Drawing of a paper net: outlines to cut, folds, and labels of glued sides."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.foot import LEGEND, foot
from isoembed.papercraft.labels import Label, labels
from isoembed.papercraft.numbers import face_numbers
from isoembed.papercraft.paper import FOOT, MARGIN
from isoembed.papercraft.placing import laid_out
from isoembed.papercraft.tabs import tabs
from isoembed.papercraft.views import views

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

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
    ruler : list of ndarray, shape (2, 2)
        At the foot of each page: 50 mm, by which one sees whether a printer has scaled it; and the marks in
        the corners of the page.
    legend : list of (str, ndarray of shape (2, 2))
        At the foot of each page, samples of the kinds of lines: ``"cut"``, ``"mountain"``, ``"valley"``.
    notes : list of Label
        At the foot of each page: a line, and what belongs to ruler and legend.
    """

    width: float
    height: float
    pages: int
    cuts: list[Floats]
    mountains: list[Floats]
    valleys: list[Floats]
    labels: list[Label]
    ruler: list[Floats]
    legend: list[tuple[str, Floats]]
    notes: list[Label]


def drawn(
    unfolding: Unfolding,
    *,
    paper: str = "A4",
    scale: float | None = None,
    size: float | None = None,
    numbers: bool = False,
) -> Drawing:
    """Draw a net.

    Parameters
    ----------
    unfolding : Unfolding
    paper : str
        One of `isoembed.papercraft.placing.PAPERS`.
    scale : float, optional
        Millimeters a unit of the solid; by default the largest with which each sheet fits on a page.

    Raises
    ------
    InvalidParameter
        There is no such paper, or a sheet does not fit on it.
    """
    layout = laid_out(unfolding, paper, scale=scale, size=size)
    unfolding, places = layout.unfolding, layout.places
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
    written = labels(outlines, folds, unfolding.sides)
    pictured: list[Floats] = []
    named: list[Label] = []
    if numbers:
        faces = [outline[face] for p, outline in enumerate(outlines) for face in unfolding.faces[p]]
        named = face_numbers(faces, np.concatenate(unfolding.numbers).tolist(), written)
        layout = replace(layout, pages=layout.pages + 1)
        low = -layout.pages * layout.height + FOOT + MARGIN
        high = (1 - layout.pages) * layout.height - MARGIN
        pictured, seen = views(unfolding, np.array([MARGIN, low]), np.array([layout.width - MARGIN, high]))
        named += seen
    kinds = [kind for kind in LEGEND if kind != "valley" or valleys]
    ruler, legend, notes = foot(layout, kinds)
    return Drawing(
        layout.width, layout.height, layout.pages, cuts, mountains, valleys, written,
        ruler + pictured, legend, notes + named,
    )  # fmt: skip
