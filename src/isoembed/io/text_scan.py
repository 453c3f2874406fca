"""Fast reading of number tables and triangles in plain text, and formatting of their lines.

Plain text is ASCII with words between blanks, and lines that end with a line feed.  Other text, and text of
unusual form, is left to the slow reader of each format, which reports the error.
"""

import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.io.files import Tables
from isoembed.io.loops import is_plain

Bytes = NDArray[np.uint8]

PIECE = 1 << 14  # rows of a table formatted together
LONGEST = 18  # digits of an integer: indices are shorter, and longer integers exceed 64 bits


def lines(template: str, table: NDArray) -> Iterator[str]:
    """Yield the rows of a table as text in pieces; the template has a ``%r`` for each entry."""
    for first in range(0, len(table), PIECE):
        rows = table[first : first + PIECE]
        yield template * len(rows) % tuple(rows.ravel().tolist())


def numbers(text: Bytes) -> Floats | None:
    """Numbers of a text; None if it contains anything else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # raised for other words
        try:
            return np.fromstring(text.tobytes(), sep=" ")
        except (DeprecationWarning, ValueError):
            return None


def triangles(coordinates: Bytes, n_vertices: int, faces: Indices) -> Tables | None:
    """Tables of a mesh from the text of its coordinates; None if it has other words, or no faces."""
    vertices = numbers(coordinates)
    if vertices is None or vertices.size != 3 * n_vertices or len(faces) == 0:
        return None
    return {"vertices": vertices.reshape(-1, 3), "faces": faces}


def plain(data: bytes) -> Bytes | None:
    """Characters of plain text, with a final line feed; None for other text."""
    text = np.frombuffer(data + b"\n", dtype=np.uint8)
    return text if is_plain(text) else None
