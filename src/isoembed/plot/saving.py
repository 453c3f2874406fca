"""Saving of surfaces and nets in any format, by file name ending."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.io.files import Writer, ending, write_atomically
from isoembed.io.net import NET_ENDINGS, net_writer
from isoembed.io.registry import SURFACE_ENDINGS, check_output
from isoembed.io.surface import surface_writer
from isoembed.plot.coloring import Quantity
from isoembed.plot.endings import PAGE_ENDINGS, PICTURE_ENDINGS, SHEET_ENDINGS
from isoembed.plot.page import page_writer
from isoembed.plot.picture import picture_writer
from isoembed.plot.sheets import sheets_writer

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding


def save_surface(
    embedding: Embedding, path: str | os.PathLike[str], *, color: str | Quantity | None = None
) -> None:
    """See `Embedding.save`."""
    form = ending(path)
    check_output(path, (*SURFACE_ENDINGS, *PAGE_ENDINGS, *PICTURE_ENDINGS))
    if color is not None and form not in PICTURE_ENDINGS:
        raise InvalidParameter(f"color is for pictures ({', '.join(PICTURE_ENDINGS)}), not for {form} files")
    writer: Writer
    if form in PICTURE_ENDINGS:
        writer = picture_writer(path, embedding, color=color)
    elif form in PAGE_ENDINGS:
        writer = page_writer(path, embedding)
    else:
        writer = surface_writer(path, embedding)
    write_atomically({Path(path): writer})


def save_unfolding(
    unfolding: Unfolding, path: str | os.PathLike[str], *, paper: str = "A4", scale: float | None = None
) -> None:
    """See `Unfolding.save`."""
    check_output(path, (*SHEET_ENDINGS, *NET_ENDINGS))
    if ending(path) in NET_ENDINGS:
        writer = net_writer(path, unfolding)
    else:
        writer = sheets_writer(path, unfolding, paper=paper, scale=scale)
    write_atomically({Path(path): writer})
