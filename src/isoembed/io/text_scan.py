"""Compiled scanning of tables in plain text.

Text is plain if it is ASCII with words between blanks, and lines that end with a line feed.  Whatever is not
plain, or not what a format usually looks like, is left to the format's own reader, which is slow and names
what is wrong.
"""

import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.io.files import Tables
from isoembed.io.loops import is_plain

Bytes = NDArray[np.uint8]

PIECE = 1 << 14  # rows of a table that become text together
LONGEST = 18  # digits of an integer: every index has fewer, and longer ones do not fit into 64 bits


def lines(template: str, table: NDArray) -> Iterator[str]:
    """Yield the rows of a table as text, each by a template with a ``%r`` an entry, a piece at a time."""
    for first in range(0, len(table), PIECE):
        rows = table[first : first + PIECE]
        yield template * len(rows) % tuple(rows.ravel().tolist())


def numbers(text: Bytes) -> Floats | None:
    """The numbers of a text with nothing else in it, or None."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # there are other words
        try:
            return np.fromstring(text.tobytes(), sep=" ")
        except (DeprecationWarning, ValueError):
            return None


def triangles(coordinates: Bytes, n_vertices: int, faces: Indices) -> Tables | None:
    """Tables of a mesh with this text of coordinates; None if there are other words in it, or no faces."""
    vertices = numbers(coordinates)
    if vertices is None or vertices.size != 3 * n_vertices or len(faces) == 0:
        return None
    return {"vertices": vertices.reshape(-1, 3), "faces": faces}


def plain(data: bytes) -> Bytes | None:
    """The characters, if they are plain text, with a line feed behind the last."""
    text = np.frombuffer(data + b"\n", dtype=np.uint8)
    return text if is_plain(text) else None
