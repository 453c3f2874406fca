"""Saving of nets as SVG, PDF, DXF and browser pages, by file name ending."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from isoembed.io.dxf_lines import ezdxf_for
from isoembed.io.files import Writer, ending, write_atomically
from isoembed.io.net import NET_ENDINGS, net_writer
from isoembed.io.registry import check_output
from isoembed.papercraft.drawing import Drawing, drawn
from isoembed.papercraft.dxf import write_dxf
from isoembed.papercraft.folding_page import folding_page_writer
from isoembed.papercraft.material import Material
from isoembed.papercraft.pdf import write_pdf
from isoembed.papercraft.svg import svg
from isoembed.plot.endings import PAGE_ENDINGS
from isoembed.plot.picture import check_drawable

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

SHEET_ENDINGS = (".svg", ".pdf", ".dxf", *PAGE_ENDINGS)


def sheets_writer(path: str | os.PathLike[str], unfolding: Unfolding, **drawing: Any) -> Writer:
    """Writer of a net in the format of the path's ending; see `write_atomically` and `write_sheets`."""
    return drawing_writer(path, unfolding, drawn(unfolding, **drawing))


def drawing_writer(path: str | os.PathLike[str], unfolding: Unfolding, pages: Drawing) -> Writer:
    """Writer of the drawing of a net in the format of the path's ending."""
    if ending(path) in PAGE_ENDINGS:
        return folding_page_writer(path, unfolding, pages)
    if ending(path) == ".pdf":
        check_drawable()
        return lambda temporary: write_pdf(temporary, pages)
    if ending(path) == ".dxf":
        ezdxf_for(f"writing {path}")
        return lambda temporary: write_dxf(temporary, pages)
    return lambda temporary: temporary.write_text(svg(pages), encoding="utf-8")


def write_sheets(
    path: str | os.PathLike[str],
    unfolding: Unfolding,
    *,
    paper: str = "A4",
    scale: float | None = None,
    size: float | tuple[str, float] | None = None,
    numbers: bool = False,
    material: Material | None = None,
) -> None:
    """Write a net for cutting, with tabs, folds, and equal numbers on glued sides.

    The outside of the solid is visible.  Solid lines are cut, dashed ones folded away from the viewer,
    dash-dotted ones toward the viewer.  Tabs are as deep as possible up to 7 mm; sides with less than about a
    millimeter of room have none.  Numbers that are ambiguous upside down are underlined.  Each page has
    samples of the lines and a ruler of 50 mm at its foot, for checking the scale of printing, and alignment
    marks in its corners.

    At a given `scale` or `size`, sheets larger than a page are divided into islands by few and short cuts
    along folds, whose sides are glued like others.

    Parameters
    ----------
    path : path
        Ends with ``.svg`` or ``.dxf`` for layers with pages arranged downward, with ``.pdf``, or with
        ``.html`` for a browser page that shows the folding of a net of one sheet beside the net.
    unfolding : Unfolding
    paper : str
        ``"A0"`` to ``"A5"``, ``"letter"``, ``"legal"``, ``"tabloid"``, ``"WIDTHxHEIGHT"``, or
        ``"roll:WIDTH"`` of unlimited length, in mm or with a unit, as in ``"8.5x11in"``.  At a given scale,
        pages are rotated if this requires fewer islands.
    scale : float, optional
        Millimeters per unit of the solid; by default the largest at which each sheet fits on a page.
    size : float or tuple, optional
        Alternative to a scale: largest extent of the solid along a coordinate axis, in mm, or
        ``("z", extent)``, that along z, and likewise of x and y.
    numbers : bool, optional
        Whether to number the faces, and draw the solid with these numbers on an additional page.
    material : Material, optional
        Material and cutting parameters; by default paper with tabs.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib (for PDF) or ezdxf (for DXF) is not
        installed.
    InvalidParameter
        The paper is unknown, a face does not fit on it, an allowance or the kerf closes a notch, or a browser
        page is requested for a net with several sheets.

    Warns
    -----
    MeshNote
        Faces are too small for a number, or hidden in the drawing of the solid.
    """
    check_output(path, SHEET_ENDINGS)
    drawing = {"paper": paper, "scale": scale, "size": size, "numbers": numbers, "material": material}
    write_atomically({Path(path): sheets_writer(path, unfolding, **drawing)})


def save_unfolding(unfolding: Unfolding, path: str | os.PathLike[str], **drawing: Any) -> None:
    """See `Unfolding.save`."""
    check_output(path, (*SHEET_ENDINGS, *NET_ENDINGS))
    if ending(path) in NET_ENDINGS:
        writer = net_writer(path, unfolding)
    else:
        writer = sheets_writer(path, unfolding, **drawing)
    write_atomically({Path(path): writer})
