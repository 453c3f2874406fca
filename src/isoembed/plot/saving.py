"""Saving of surfaces in any format, by file name ending."""

from __future__ import annotations

import os
from pathlib import Path

from numpy.typing import ArrayLike

from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.io.files import Writer, ending, write_atomically
from isoembed.io.registry import SURFACE_ENDINGS, check_output
from isoembed.io.surface import surface_writer
from isoembed.plot.coloring import Quantity
from isoembed.plot.endings import PAGE_ENDINGS, PICTURE_ENDINGS
from isoembed.plot.page import page_writer
from isoembed.plot.picture import picture_writer


def save_surface(
    embedding: Embedding, path: str | os.PathLike[str], *, color: str | Quantity | ArrayLike | None = None
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
