"""Drawing of a paper net: outlines to cut, folds, and labels of glued sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.labels import WIDTH, Label, labels
from isoembed.papercraft.paper import MARGIN
from isoembed.papercraft.placing import laid_out
from isoembed.papercraft.tabs import tabs

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

NOTE = 3.0  # mm, the size of what is written at the foot
RULER, TICK = 50, 10  # mm
LEGEND = {
    "cut": (92.0, "cut"),
    "mountain": (114.0, "fold away from you"),
    "valley": (158.0, "fold toward you"),
}
"""By kind of line, where a sample of it begins, in mm from the left, and what it says."""
SAMPLE = 10.0  # mm
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
        At the foot of each page: 50 mm, by which one sees whether a printer has scaled it.
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
    unfolding: Unfolding, *, paper: str = "A4", scale: float | None = None, size: float | None = None
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
    unfolding, places, pages, scale = layout.unfolding, layout.places, layout.pages, layout.scale
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
    width, height = layout.width, layout.height
    kinds = [kind for kind in LEGEND if kind != "valley" or valleys]
    ruler, legend, notes = [], [], []
    for k in range(pages):
        low = -(k + 1) * height
        of = f", page {k + 1} of {pages}" if pages > 1 else ""
        said = (
            f"outside of the solid{of}; {scale:.4g} mm a unit; print at 100 %: the ruler is {RULER} mm long"
        )
        notes.append(Label(said, width / 2, low + 1.6 * NOTE, 0.0, NOTE))
        line, end = low + 3.2 * NOTE, MARGIN + RULER
        ticks = np.arange(MARGIN, end + 1, TICK)
        ruler += [_line(MARGIN, line, end, line), *(_line(x, line, x, line + 0.6 * NOTE) for x in ticks)]
        notes.append(_after(f"{RULER} mm", end, line))
        for kind in kinds:
            x, said = LEGEND[kind]
            legend.append((kind, _line(x, line, x + SAMPLE, line)))
            notes.append(_after(said, x + SAMPLE, line))
    numbers = labels(outlines, folds, unfolding.sides)
    return Drawing(width, height, pages, cuts, mountains, valleys, numbers, ruler, legend, notes)


def _line(x: float, y: float, to_x: float, to_y: float) -> Floats:
    return np.array([[x, y], [to_x, to_y]])


def _after(text: str, x: float, y: float) -> Label:
    """Words that begin a little to the right of a point."""
    return Label(text, x + (len(text) / 2 + 1) * WIDTH * NOTE, y, 0.0, NOTE)
