"""Layout of a net on pages: scale, portrait or landscape, islands, rotation and packing of the sheets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import is_number
from isoembed.papercraft.fitting import best_turn, compact_turn
from isoembed.papercraft.islands import cut_along, partition, parts
from isoembed.papercraft.packing import SLACK, packed
from isoembed.papercraft.paper import FOOT, FORMATS, Paper

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

GAP = 14.0  # mm, between sheets, for the tabs of both
NO_FORMAT = "no format is large enough: give a page size, paper='WIDTHxHEIGHT' in mm"
AXES = "x", "y", "z"
RIGHT_ANGLE = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class Placing:
    """Placement of a sheet, in mm from the upper left corner, y upward; pages are arranged downward.

    Attributes
    ----------
    turn : ndarray, shape (2, 2)
    shift : ndarray, shape (2,)
    """

    turn: Floats
    shift: Floats

    def put(self, points: Floats) -> Floats:
        """Transform points of the sheet to the paper."""
        return points @ self.turn + self.shift


@dataclass(frozen=True, eq=False)
class Layout:
    """A net on pages.

    Attributes
    ----------
    unfolding : Unfolding
        Sheets; those larger than a page are divided into islands.
    places : list of Placing
        Placement of each sheet.
    pages : int
    width, height : float
        Size of a page, mm.
    scale : float
        Millimeters per unit of the solid.
    """

    unfolding: Unfolding
    places: list[Placing]
    pages: int
    width: float
    height: float
    scale: float


def laid_out(
    unfolding: Unfolding,
    paper: str = "A4",
    *,
    scale: float | None = None,
    size: float | tuple[str, float] | None = None,
    beyond: float = 0.0,
) -> Layout:
    """Arrange a net on pages.

    Of portrait and landscape, the one with fewer islands, then fewer pages, is used at a given scale or size.

    Parameters
    ----------
    unfolding : Unfolding
    paper, scale, size
        See `isoembed.papercraft.write_sheets`.
    beyond : float
        Extent of cuts beyond that of tabs, mm.

    Raises
    ------
    InvalidParameter
        The paper is unknown, a face is larger than a page, both scale and size are given, or the solid has
        no extent along the axis.
    """
    page = replace(Paper.of(paper), beyond=beyond)
    option = _option(scale, size)
    if option is None:
        return _on_pages(unfolding, page, min(best_turn(sheet, page.room)[1] for sheet in unfolding.sheets))
    name, axis, value = option
    wanted = value if name == "scale" else value / _extent(unfolding, axis)
    pages = [one for one in dict.fromkeys((page, page.turned)) if _largest(unfolding, one)[0] >= wanted]
    if not pages:
        raise InvalidParameter(_too_large(unfolding, page, wanted, *option))
    layouts = [_in_islands(unfolding, one, wanted) for one in pages]
    return min(layouts, key=lambda one: (len(one.unfolding.sheets), one.pages, _cut_length(one.unfolding)))


def _option(scale: float | None, size: float | tuple[str, float] | None) -> tuple[str, str, float] | None:
    """Name of the scale or size, if given, axis of the size, if it has one, and value."""
    axis = ""
    if isinstance(size, tuple):
        if len(size) != 2 or size[0] not in AXES or size[1] is None:
            raise InvalidParameter(f"size is {size!r}, not a number or such as ('z', 200)")
        axis, size = size
    options = [
        (name, along, value)
        for name, along, value in (("scale", "", scale), ("size", axis, size))
        if value is not None
    ]
    for name, along, value in options:
        if not is_number(value) or not 0 < value < np.inf:
            text = f"{value:g}" if is_number(value) else repr(value)
            raise InvalidParameter(f"{_named(name, along, text)}, not a positive finite number of mm")
    if len(options) == 2:
        raise InvalidParameter(
            f"give either a scale, here {scale:g} mm, or a size, here {size:g} mm, not both"
        )
    return options[0] if options else None


def _named(option: str, axis: str, value: str) -> str:
    return f"{option}{f' in {axis}' if axis else ''} is {value}"


def _extent(unfolding: Unfolding, axis: str) -> float:
    """Extent of the solid along an axis, or the largest."""
    if unfolding.vertices is None:
        raise InvalidParameter("a size requires the solid, which this net does not have: give a scale")
    extents = np.ptp(unfolding.vertices, axis=0)
    found = extents[AXES.index(axis)] if axis else extents.max()
    if found < 1e-9 * extents.max():  # a smaller extent counts as zero
        raise InvalidParameter(f"a size in {axis} is given, but the solid has no extent in {axis}")
    return float(found)


def _uncut(unfolding: Unfolding) -> Iterator[tuple[str, Floats]]:
    """Uncut parts with their names: faces, or sheets with unknown faces."""
    for p, sheet in enumerate(unfolding.sheets):
        if not unfolding.faces:
            yield f"sheet {p}", sheet
        else:
            yield from ((name, sheet[corners]) for name, corners in parts(unfolding, p))


def _largest(unfolding: Unfolding, page: Paper) -> tuple[float, str]:
    """Largest scale at which all faces fit on a page in this orientation, and the face that limits it."""
    found, worst = np.inf, ""
    for name, part in _uncut(unfolding):
        if page.room.min() >= found * np.hypot(*np.ptp(part, axis=0)):
            continue  # fits in any orientation
        largest = best_turn(part, page.room, oblique=True)[1]
        if largest < found * (1 - SLACK):
            found, worst = largest, name
    return found * (1 + SLACK), worst


def _too_large(unfolding: Unfolding, page: Paper, wanted: float, option: str, axis: str, value: float) -> str:
    """Error message about the face that does not fit, with a scale and a paper for which it would."""
    largest, name = max(_largest(unfolding, one) for one in (page, page.turned))
    maximum = value * largest / wanted
    digits = 10.0 ** (np.floor(np.log10(maximum)) - 3)
    american = page.name in FORMATS and not page.name.startswith("A")
    series = [other for other in FORMATS if page.name not in FORMATS or other.startswith("A") != american]
    by_area = sorted(FORMATS, key=lambda other: (other not in series, np.prod(FORMATS[other])))
    papers = [replace(Paper.of(other), beyond=page.beyond) for other in by_area]
    enough = (
        f"paper='{paper.name}' is large enough"
        for paper in papers
        if max(_largest(unfolding, one)[0] for one in (paper, paper.turned)) >= wanted
    )
    largest_value = f"{np.floor(maximum / digits) * digits:.6g}"
    if axis:
        largest_value = f"('{axis}', {largest_value})"
    return (
        f"{_named(option, axis, f'{value:.6g} mm')}, but {name} fits on {page.name} up to "
        f"{option}={largest_value}; {next(enough, NO_FORMAT)}"
    )


def _in_islands(unfolding: Unfolding, page: Paper, scale: float) -> Layout:
    """Layout with islands of the sheets that do not fit."""
    cuts = [
        []
        if best_turn(sheet, page.room, oblique=True)[1] * (1 + SLACK) >= scale
        else partition(sheet, [corners for _, corners in parts(unfolding, p)], page.room / scale)
        for p, sheet in enumerate(unfolding.sheets)
    ]
    return _on_pages(cut_along(unfolding, cuts) if any(cuts) else unfolding, page, scale)


def _cut_length(unfolding: Unfolding) -> float:
    lengths = [np.hypot(*(np.roll(sheet, -1, axis=0) - sheet).T) for sheet in unfolding.sheets]
    return float(sum(lengths[p][k] for (p, k), _ in unfolding.sides))


def _on_pages(unfolding: Unfolding, page: Paper, scale: float) -> Layout:
    """Layout of sheets that fit on pages in this orientation."""
    ways = zip(*(_turned(scale * sheet, page.room) for sheet in unfolding.sheets), strict=True)
    tries = [_packed(unfolding.sheets, turns, page, scale) for turns in ways]
    used = [float(np.ceil((corners + sizes)[:, 1].max())) for sizes, _, corners, _ in tries]
    best = min(range(2), key=lambda k: used[k] if page.is_roll else int(tries[k][3].max()))
    sizes, turns, corners, pages = tries[best]
    height = used[best] + FOOT + 2 * page.margin if page.is_roll else page.height
    room = np.array([page.width, height - FOOT]) - 2 * page.margin
    for k in range(int(pages.max()) + 1):  # center the sheets
        mine = pages == k
        corners[mine] += page.margin + (room - (corners + sizes)[mine].max(axis=0)) / 2 + [0, k * height]
    placings = []
    for sheet, turn, (left, top) in zip(unfolding.sheets, turns, corners.tolist(), strict=True):
        there = scale * sheet @ turn
        placings.append(Placing(scale * turn, np.array([left - there[:, 0].min(), -top - there[:, 1].max()])))
    return Layout(unfolding, placings, int(pages.max()) + 1, page.width, height, scale)


def _turned(sheet: Floats, room: Floats) -> tuple[Floats, Floats]:
    """Two rotations of a sheet in mm: one with the best fit, one with the smallest bounding box."""
    turn, largest = best_turn(sheet, room)
    if largest * (1 + SLACK) >= 1:
        return turn, compact_turn(sheet, room)
    turn, _ = best_turn(sheet, room, oblique=True)
    return turn, turn


def _packed(
    sheets: Sequence[Floats], turns: Sequence[Floats], page: Paper, scale: float
) -> tuple[Floats, list[Floats], Floats, Indices]:
    """Sizes of the sheets on the paper, their rotations, their upper left corners, and their pages."""
    sizes = scale * np.array(
        [np.ptp(sheet @ turn, axis=0) for sheet, turn in zip(sheets, turns, strict=True)]
    )
    corners, pages, turned = packed(sizes, page.room, GAP + 2 * page.beyond)
    sizes[turned] = sizes[turned][:, ::-1]
    upright = [
        turn @ RIGHT_ANGLE if is_turned else turn for turn, is_turned in zip(turns, turned, strict=True)
    ]
    return sizes, upright, corners, pages
