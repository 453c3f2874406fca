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
from isoembed.kernel import kernel

Bytes = NDArray[np.uint8]

PIECE = 1 << 14  # rows of a table that become text together
LONGEST = 18  # digits of an integer: every index has fewer, and longer ones do not fit into 64 bits

TAB, FEED, RETURN, SPACE, HASH, ZERO, NINE, BACKSLASH = (ord(c) for c in "\t\n\r #09\\")


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
    return text if _is_plain(text) else None


@kernel
def _is_plain(text: Bytes) -> bool:
    """Whether there are but printable ASCII, blanks and line feeds, and no line goes on in the next."""
    for i in range(len(text)):
        c = text[i]
        if c == RETURN:
            if text[i + 1] != FEED:
                return False
        elif c == BACKSLASH or c > 126 or (c < SPACE and c != TAB and c != FEED):
            return False
    return True


@kernel
def in_word(c: int) -> bool:
    """Whether a character of plain text belongs to a word: comments do not."""
    return c > SPACE and c != HASH


@kernel
def ends(c: int) -> bool:
    """Whether a line, or what it says, ends with this character."""
    return c in (FEED, HASH)


@kernel
def word_begin(text: Bytes, i: int) -> int:
    """Where the next word begins, from here on in this line; or where the line, or what it says, ends."""
    while text[i] <= SPACE and text[i] != FEED:
        i += 1
    return i


@kernel
def word_end(text: Bytes, i: int) -> int:
    """Where the word ends that is here."""
    while in_word(text[i]):
        i += 1
    return i


@kernel
def words_end(text: Bytes, count: int) -> int:
    """Where so many words end, over all lines; or -1 if there are fewer."""
    i = 0
    for _ in range(count):
        while i < len(text) and text[i] <= SPACE:
            i += 1
        if i == len(text):
            return -1
        while i < len(text) and text[i] > SPACE:
            i += 1
    return i


@kernel
def next_line(text: Bytes, i: int) -> int:
    """Where the next line begins."""
    while text[i] != FEED:
        i += 1
    return i + 1


@kernel
def copy_words(text: Bytes, i: int, count: int, copy: Bytes, end: int) -> tuple[int, int]:
    """Append so many words and blanks to a copy; where both end now, or -1 if there are fewer words."""
    for _ in range(count):
        i = word_begin(text, i)
        if ends(text[i]):
            return -1, end
        while in_word(text[i]):
            copy[end] = text[i]
            i, end = i + 1, end + 1
        copy[end] = SPACE
        end += 1
    return i, end


@kernel
def natural(text: Bytes, i: int, separator: int = SPACE) -> tuple[int, int]:
    """The natural number that the next word is, up to a separator, and its end; -1 if it is none."""
    i = word_begin(text, i)
    begin, value = i, 0
    while ZERO <= text[i] <= NINE and i < begin + LONGEST:
        value = 10 * value + int(text[i]) - ZERO
        i += 1
    if i == begin or (in_word(text[i]) and text[i] != separator):
        return -1, i
    while in_word(text[i]):
        i += 1
    return value, i
