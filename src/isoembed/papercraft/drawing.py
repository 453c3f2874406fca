"""Drawing of a paper net in layers: cut (widened by kerf and allowance), mountain, valley, seam, engrave."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter, warn_of_mesh
from isoembed.gluing.offset import offset
from isoembed.papercraft.labels import Label, labels
from isoembed.papercraft.material import Material
from isoembed.papercraft.numbers import face_numbers
from isoembed.papercraft.page_foot import LEGEND, foot, foot_of_drawing
from isoembed.papercraft.paper import FOOT, MARGIN
from isoembed.papercraft.perforation import pieces
from isoembed.papercraft.placing import laid_out
from isoembed.papercraft.stitches import stitches
from isoembed.papercraft.tabs import DEPTH, tabs
from isoembed.papercraft.thickness import thickened
from isoembed.papercraft.views import views

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

LEAST = 1e-3  # radians; smaller folds are omitted
ALLOWANCE_LIMIT = 1.5  # allowances: right angles keep their corners, sharper ones are cut off
DECIMALS = 6  # of a millimeter in files: nearly flat vertices magnify rounding errors a thousandfold


@dataclass(frozen=True, eq=False)
class Fold:
    """A fold on the paper.

    Attributes
    ----------
    line : ndarray, shape (2, 2)
        Endpoints of the fold.
    angle : float or None
        Fold angle in radians, positive away from an outside viewer.  None for a tab, which is folded until it
        meets the other side.
    pieces : ndarray, shape (m, 2, 2)
        Pieces of the fold that are cut or scored.
    """

    line: Floats
    angle: float | None
    pieces: Floats

    @property
    def kind(self) -> str:
        """``"mountain"`` or ``"valley"``."""
        return "valley" if self.angle is not None and self.angle < 0 else "mountain"


@dataclass(frozen=True, eq=False)
class Drawing:
    """Lines and numbers on pages arranged downward, in mm from the upper left corner, y upward.

    No line is repeated.  The layers of files are ``cut``, ``mountain``, ``valley``, ``seam``, ``glue``,
    ``engrave`` (labels, ruler, legend, notes), and ``solid`` for the drawing of the solid.

    Attributes
    ----------
    width, height : float
        Size of a page.
    pages : int
        Number of pages, including the last one with the drawing of the solid, if any.
    scale : float
        Millimeters per unit of the solid.
    cuts : list of ndarray, shape (n, 2)
        Closed outlines, including tabs or seam allowance, and half of the kerf.
    holes : list of (float, float, float)
        Circles to cut: center and radius.
    seams : list of ndarray, shape (n, 2)
        Closed outlines of the net, if the cuts are wider by an allowance.
    folds : list of Fold
    glue : list of ndarray, shape (n, 2)
        Glue areas in the middle of each tab.
    labels : list of Label
    ruler : list of ndarray, shape (2, 2)
        At the foot of each page of the net: a ruler of 50 mm, for checking the scale of printing; and the
        marks in the page corners.
    legend : list of (str, ndarray of shape (2, 2))
        Line samples at the foot of each page of the net: ``"cut"``, ``"mountain"``, ``"valley"``.
    notes : list of Label
        At the foot of each page: a line of text, and labels of ruler and legend; and face numbers.
    pictured : list of ndarray, shape (2, 2)
        Visible edges of the solid, on the last page of a net with numbers.
    captions : list of Label
        Face numbers in the drawing of the solid, and a line of text at its foot.
    net : Unfolding
        Printed net, divided into islands, and with the gaps of a thick sheet.
    kerf : float
        Beam width in mm; cuts are offset by half of it.
    error : float
        Rounding error of the points of the solid, mm.
    any_surface : bool
        Whether sides without a number are a boundary, and handles are permitted.
    """

    width: float
    height: float
    pages: int
    scale: float
    cuts: list[Floats]
    holes: list[tuple[float, float, float]]
    seams: list[Floats]
    folds: list[Fold]
    glue: list[Floats]
    labels: list[Label]
    ruler: list[Floats]
    legend: list[tuple[str, Floats]]
    notes: list[Label]
    pictured: list[Floats]
    captions: list[Label]
    net: Unfolding
    kerf: float
    error: float
    any_surface: bool

    @property
    def underlines(self) -> list[Floats]:
        """Lines below labels that are ambiguous upside down."""
        return [one.underline for one in self.labels if one.underline is not None]


def drawn(
    unfolding: Unfolding,
    *,
    paper: str = "A4",
    scale: float | None = None,
    size: float | tuple[str, float] | None = None,
    numbers: bool = False,
    material: Material | None = None,
) -> Drawing:
    """Draw a net.

    Parameters
    ----------
    unfolding : Unfolding
    paper, scale, size, numbers, material
        See `isoembed.papercraft.write_sheets`.

    Raises
    ------
    InvalidParameter
        The paper is unknown, a face does not fit on it, an allowance or the kerf closes a notch, or numbers
        are requested without known faces or with a thickness.
    """
    vertices = unfolding.vertices
    if numbers and vertices is None:
        raise InvalidParameter("numbers require the faces of a solid, which this net does not have")
    if not isinstance(material := material or Material(), Material):
        raise InvalidParameter(f"material is {material!r}, not an isoembed.papercraft.Material")
    beyond = _beyond(material)
    layout = laid_out(unfolding, paper, scale=scale, size=size, beyond=beyond)
    if material.thickness:
        if numbers:
            raise InvalidParameter("numbers of faces cannot be combined with a thickness")
        thick = thickened(layout.unfolding, material, layout.scale)
        layout = laid_out(thick, paper, scale=layout.scale, beyond=beyond)
    unfolding, places = layout.unfolding, layout.places
    outlines = [place.put(sheet) for place, sheet in zip(places, unfolding.sheets, strict=True)]
    angles = [some[np.abs(some) > LEAST] for some in unfolding.angles]
    folds = [
        place.put(some[np.abs(bent) > LEAST])
        for place, some, bent in zip(places, unfolding.folds, unfolding.angles, strict=True)
    ]
    standing = tabs(outlines, unfolding.sides) if material.joints == "tabs" else {}
    holes = (
        stitches(outlines, unfolding.sides, material)
        if material.joints == "stitches"
        else [np.empty((0, 2))] * len(outlines)
    )
    cuts, creases, glue = [], [], []
    for p, (outline, inside, bent) in enumerate(zip(outlines, folds, angles, strict=True)):
        around: list[Floats] = []
        for k, corner in enumerate(outline):
            around.append(corner)
            if (p, k) in standing:
                side = outline[[k, (k + 1) % len(outline)]]
                around += list(standing[p, k])
                creases.append(Fold(side, None, pieces(side, material)))
                glue.append(_middle(np.concatenate([side, standing[p, k][::-1]])))
        cuts.append(_widened(np.array(around), material, f"sheet {p}"))
        creases += [
            Fold(line, angle, pieces(line, material))
            for line, angle in zip(inside, bent.tolist(), strict=True)
        ]
    obstacles = [
        np.concatenate([lines, _crosses(some, material.hole)])
        for lines, some in zip(folds, holes, strict=True)
    ]
    written = labels(outlines, obstacles, unfolding.sides)
    has_valleys = any(fold.kind == "valley" for fold in creases)
    kinds = [kind for kind in LEGEND if kind != "valley" or has_valleys]
    ruler, legend, notes = foot(layout, kinds)
    pictured: list[Floats] = []
    captions: list[Label] = []
    if numbers and vertices is not None:
        faces = [outline[face] for p, outline in enumerate(outlines) for face in unfolding.faces[p]]
        numbered = face_numbers(faces, np.concatenate(unfolding.numbers).tolist(), written)
        notes += [one for one in numbered if one is not None]
        layout = replace(layout, pages=layout.pages + 1)
        low = -layout.pages * layout.height + FOOT + MARGIN
        high = (1 - layout.pages) * layout.height - MARGIN
        pictured, seen = views(
            unfolding, vertices, np.array([MARGIN, low]), np.array([layout.width - MARGIN, high])
        )
        captions = [*seen, foot_of_drawing(layout)]
        _say_which_have_none(len(faces), numbered.count(None), len(faces) - len({one.text for one in seen}))
    radius = (material.hole - material.kerf) / 2
    precision = unfolding.precision
    return Drawing(
        layout.width,
        layout.height,
        layout.pages,
        layout.scale,
        cuts,
        [(x, y, radius) for x, y in np.concatenate(holes).tolist()],
        outlines if material.allowance else [],
        creases,
        glue,
        written,
        ruler,
        legend,
        notes,
        pictured,
        captions,
        layout.unfolding,
        material.kerf,
        0.0 if precision is None else layout.scale * precision.vertex_error,
        unfolding.any_surface,
    )


def _say_which_have_none(faces: int, small: int, unseen: int) -> None:
    """Warn of faces without a number."""
    where = [f"{small} on the net, where they are too small"] * bool(small)
    where += [f"{unseen} in the drawing of the solid, where they are hidden or too small"] * bool(unseen)
    if where:
        warn_of_mesh(f"faces without a number, of {faces}: {'; '.join(where)}")


def _beyond(material: Material) -> float:
    """Largest distance of a cut from the outline of a sheet, minus the depth of a tab."""
    farthest = (
        np.hypot(ALLOWANCE_LIMIT, 1.0) * material.allowance
    )  # ends of the cut across a needle-shaped corner
    return max(0.0, float(farthest) + material.kerf - DEPTH)


def _widened(outline: Floats, material: Material, name: str) -> Floats:
    """Outline of the cut: widened by the allowance and half of the kerf."""
    if material.allowance:
        outline = offset(outline, material.allowance, name, ALLOWANCE_LIMIT)
    # Corners of less than 6 degrees are cut off.
    return offset(outline, material.kerf / 2, name, 20.0) if material.kerf else outline


def _crosses(middles: Floats, size: float) -> Floats:
    """Crosses over the holes, as obstacles for labels."""
    across = np.array([[[-size / 2, 0.0], [size / 2, 0.0]], [[0.0, -size / 2], [0.0, size / 2]]])
    return np.asarray(middles[:, None, None] + across).reshape(-1, 2, 2)


def _middle(tab: Floats) -> Floats:
    """Glue area of a tab, inset from its sides to avoid repeated lines."""
    center = tab.mean(axis=0)
    return np.asarray(center + 0.75 * (tab - center))
