# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled scanning of OBJ, OFF and STL text: words, numbers, vertices and triangles.

Text of unusual form is left to the slow reader of each format, which reports the error.
"""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Byte, ConstByte, Int

TAB = cython.declare(cython.longlong, 9)
FEED = cython.declare(cython.longlong, 10)
RETURN = cython.declare(cython.longlong, 13)
SPACE = cython.declare(cython.longlong, 32)
HASH = cython.declare(cython.longlong, 35)
ZERO = cython.declare(cython.longlong, 48)
NINE = cython.declare(cython.longlong, 57)
BACKSLASH = cython.declare(cython.longlong, 92)
F = cython.declare(cython.longlong, 102)
V = cython.declare(cython.longlong, 118)
LOWER = cython.declare(cython.longlong, 32)
VERTEX = cython.declare(cython.longlong, 118)
FACE = cython.declare(cython.longlong, 102)
SLASH = cython.declare(cython.longlong, 47)
LONGEST = cython.declare(cython.longlong, 18)  # digits of an integer, as in `text_scan`


def is_plain(text: ConstByte[::1]):
    """Whether text is printable ASCII, blanks and line feeds, without line continuations."""
    for i in range(text.shape[0]):
        c = text[i]
        if c == RETURN:
            if text[i + 1] != FEED:
                return False
        elif c == BACKSLASH or c > 126 or (c < SPACE and c != TAB and c != FEED):
            return False
    return True


@cython.cfunc
@cython.exceptval(check=False)
def in_word(c: Int) -> cython.bint:
    """Whether a character of plain text belongs to a word; comments do not."""
    return c > SPACE and c != HASH


@cython.cfunc
@cython.exceptval(check=False)
def ends(c: Int) -> cython.bint:
    """Whether this character ends a line or starts a comment."""
    return c in (FEED, HASH)


@cython.cfunc
@cython.exceptval(check=False)
def word_begin(text: ConstByte[::1], i: Int) -> Int:
    """Start of the next word in the line, or the end of the line's contents."""
    while text[i] <= SPACE and text[i] != FEED:
        i += 1
    return i


@cython.cfunc
@cython.exceptval(check=False)
def word_end(text: ConstByte[::1], i: Int) -> Int:
    """End of the word at this position."""
    while in_word(text[i]):
        i += 1
    return i


def words_end(text: ConstByte[::1], count: Int):
    """End of the first `count` words, across lines; -1 if there are fewer."""
    i: Int = 0
    for _ in range(count):
        while i < text.shape[0] and text[i] <= SPACE:
            i += 1
        if i == text.shape[0]:
            return -1
        while i < text.shape[0] and text[i] > SPACE:
            i += 1
    return i


@cython.cfunc
@cython.exceptval(check=False)
def next_line(text: ConstByte[::1], i: Int) -> Int:
    """Start of the next line."""
    while text[i] != FEED:
        i += 1
    return i + 1


@cython.cfunc
@cython.exceptval(check=False)
def copy_words(
    text: ConstByte[::1], i: Int, count: Int, copy: Byte[::1], end: Int
) -> tuple[cython.longlong, cython.longlong]:
    """Append `count` words, separated by blanks, to a copy; return both ends, or -1 if words are missing."""
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


@cython.cfunc
@cython.exceptval(check=False)
def natural(text: ConstByte[::1], i: Int, separator: Int) -> tuple[cython.longlong, cython.longlong]:
    """Value and end of a natural number in the next word, up to a separator; -1 if it is none."""
    i = word_begin(text, i)
    begin = i
    value: Int = 0
    while ZERO <= text[i] <= NINE and i < begin + LONGEST:
        value = 10 * value + text[i] - ZERO
        i += 1
    if i == begin or (in_word(text[i]) and text[i] != separator):
        return -1, i
    while in_word(text[i]):
        i += 1
    return value, i


def scan_off(text: ConstByte[::1], n_vertices: Int, n_faces: Int):
    """Text of the coordinates, and triangles; both empty if a line is unusual."""
    coordinates: Byte[::1] = np.empty(text.shape[0] + 4, dtype=np.uint8)
    faces: Int[:, ::1] = np.empty((n_faces, 3), dtype=np.int64)
    end: Int = 0
    row: Int = 0
    i: Int = 0
    while row < n_vertices + n_faces:
        if i == text.shape[0]:
            return np.asarray(coordinates[:0]), np.asarray(faces[:0])
        i = word_begin(text, i)
        if not ends(text[i]):
            if row < n_vertices:
                i, end = copy_words(text, i, 3, coordinates, end)
                if i < 0:
                    return np.asarray(coordinates[:0]), np.asarray(faces[:0])
            else:
                count, i = natural(text, i, SPACE)
                if count != 3:
                    return np.asarray(coordinates[:0]), np.asarray(faces[:0])
                for corner in range(3):
                    index, i = natural(text, i, SPACE)
                    if index < 0:
                        return np.asarray(coordinates[:0]), np.asarray(faces[:0])
                    faces[row - n_vertices, corner] = index
            row += 1
        i = next_line(text, i)
    return np.asarray(coordinates[:end]), np.asarray(faces)


def scan_stl(text: ConstByte[::1]):
    """Text of the corners, and the numbers of corners and facets; empty text if a line is unusual."""
    coordinates: Byte[::1] = np.empty(text.shape[0] + 3, dtype=np.uint8)
    end: Int = 0
    corners: Int = 0
    facets: Int = 0
    i: Int = 0
    while i < text.shape[0]:
        i = word_begin(text, i)
        if text[i] | LOWER == V:  # vertex
            i, end = copy_words(text, word_end(text, i), 3, coordinates, end)
            if i < 0:
                return np.asarray(coordinates[:0]), 1, 0
            corners += 1
        elif text[i] | LOWER == F:  # facet
            facets += 1
        i = next_line(text, i)
    return np.asarray(coordinates[:end]), corners, facets


def scan_obj(text: ConstByte[::1]):
    """Text of the coordinates, number of vertices, and triangles; empty if a line is unusual."""
    coordinates: Byte[::1] = np.empty(text.shape[0] + 3, dtype=np.uint8)
    faces: Int[:, ::1] = np.empty((text.shape[0] // 7 + 1, 3), np.int64)
    end: Int = 0
    vertices: Int = 0
    row: Int = 0
    i: Int = 0
    while i < text.shape[0]:
        i = word_begin(text, i)
        if in_word(text[i]) and not in_word(text[i + 1]):
            if text[i] == VERTEX:
                i, end = copy_words(text, i + 1, 3, coordinates, end)
                if i < 0:
                    return np.asarray(coordinates[:0]), 0, np.asarray(faces[:0])
                vertices += 1
            elif text[i] == FACE:
                i += 1
                for corner in range(3):
                    number, i = natural(text, i, SLASH)
                    if number <= 0:
                        return np.asarray(coordinates[:0]), 0, np.asarray(faces[:0])
                    faces[row, corner] = number - 1
                row += 1
                if not ends(text[word_begin(text, i)]):
                    return np.asarray(coordinates[:0]), 0, np.asarray(faces[:0])
        i = next_line(text, i)
    return np.asarray(coordinates[:end]), vertices, np.asarray(faces[:row])
