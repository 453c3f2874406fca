"""Output of nets in SVG, PDF, DXF and as browser pages."""

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
    """Return what writes a net in the format of this ending; see `write_atomically` and `write_sheets`."""
    return drawing_writer(path, unfolding, drawn(unfolding, **drawing))


def drawing_writer(path: str | os.PathLike[str], unfolding: Unfolding, pages: Drawing) -> Writer:
    """Return what writes the drawing of a net in the format of this ending."""
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
    size: float | None = None,
    numbers: bool = False,
    material: Material | None = None,
) -> None:
    """Write a net to cut out: with tabs, folds, and the same number on both sides that are glued.

    One sees the outside of the solid.  Solid lines are cut, dashed ones folded away from oneself, dash-dotted
    ones toward oneself.  Tabs are as deep as there is room for them, 7 mm at most; where there is none for a
    millimeter, a side has none.  A number that would be another one upside down is underlined.  At the foot
    of each page are samples of the lines and a ruler of 50 mm, which shows whether a printer has scaled it,
    and in its corners marks to align it.

    At a given `scale` or `size`, sheets that are larger than a page are cut along folds into islands, as few
    and with cuts as short as are found, and the sides of each cut are glued like others.

    Parameters
    ----------
    path : path
        Ending in ``.svg`` or ``.dxf``, in layers and with the pages below one another, or in ``.pdf``; or in
        ``.html``, a page for the browser that shows how a net of one sheet is folded, with the net beside it.
    unfolding : Unfolding
    paper : str
        ``"A0"`` to ``"A5"``, ``"letter"``, ``"legal"``, ``"tabloid"``, ``"WIDTHxHEIGHT"``, or
        ``"roll:WIDTH"``, which is as long as needed, in mm or with a unit, as ``"8.5x11in"``.  At a given
        scale, pages are turned where that takes fewer islands.
    scale : float, optional
        Millimeters a unit of the solid; by default the largest with which each sheet fits on a page.
    size : float, optional
        Instead of a scale: millimeters of the solid along that axis of its coordinates along which it is
        longest.
    numbers : bool, optional
        Number the faces, and draw the solid with the same numbers on another page.
    material : Material, optional
        What it is cut from and with; by default paper, with tabs.

    Raises
    ------
    FileError
        The ending is not known, the file cannot be written, or matplotlib for PDF or ezdxf for DXF is not
        installed.
    InvalidParameter
        There is no such paper, a face does not fit on it, an allowance or the kerf closes a notch, or of a
        page for the browser the net has several sheets.

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
