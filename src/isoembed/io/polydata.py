"""Polygons in legacy VTK text files: what QuasiLocalMeasures of the Einstein Toolkit writes of a horizon."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MARK = "POLYDATA"
ATTRIBUTES = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9}


@dataclass
class PolyData:
    """Points, the polygons between them, and scalars and the like at the points."""

    points: Floats
    polygons: list[Indices] = field(default_factory=list)
    fields: dict[str, Floats] = field(default_factory=dict)


def is_polydata(text: str) -> bool:
    """Whether a text begins like a legacy VTK file of polygons."""
    return text.startswith("# vtk DataFile") and MARK in text[:2000].upper()


@dataclass
class _Words:
    """The words of a file one after the other."""

    words: list[str]
    source: str
    at: int = 0

    def more(self) -> bool:
        return self.at < len(self.words)

    def next(self) -> str:
        self.at += 1
        if self.at > len(self.words):
            raise FileError(f"{self.source} ends early")
        return self.words[self.at - 1]

    def natural(self, what: str) -> int:
        word = self.next()
        if not word.isdigit():
            raise FileError(f"{self.source}: {word!r} is not a number of {what}")
        return int(word)

    def numbers(self, count: int, what: str) -> Floats:
        words = self.words[self.at : self.at + count]
        try:
            values = np.array(words, dtype=np.float64)
        except ValueError as error:
            raise FileError(f"{self.source}: among the {what}, {error}") from None
        if len(values) < count:
            raise FileError(f"{self.source} ends after {len(values)} of {count} numbers of the {what}")
        self.at += count
        return values


def parse_polydata(text: str, source: str) -> PolyData:
    """Read a legacy VTK text file of polygons.

    Parameters
    ----------
    text : str
        The file.
    source : str
        Its name, for messages.

    Raises
    ------
    FileError
        It is binary, cut short, or has something that is not known; the message names it.
    """
    lines = text.split("\n", 3)
    if len(lines) < 4 or lines[2].strip().upper() != "ASCII":
        raise FileError(f"{source} is a binary VTK file of polygons: they are read from text only")
    words = _Words(lines[3].split(), source)
    data, at_points, n = PolyData(np.empty((0, 3))), True, 0
    while words.more():
        key = words.next().upper()
        if key == "DATASET":
            words.next()
        elif key == "POINTS":
            n = words.natural("points")
            words.next()
            data.points = words.numbers(3 * n, "points").reshape(n, 3)
        elif key in ("POLYGONS", "VERTICES", "LINES"):
            cells = _cells(words, key, len(data.points))
            data.polygons += cells if key == "POLYGONS" else []
        elif key in ("POINT_DATA", "CELL_DATA"):
            at_points, n = key == "POINT_DATA", words.natural("values")
        elif key == "SCALARS" or key in ATTRIBUTES or key == "FIELD":
            arrays = _arrays(words, key, n)
            data.fields |= arrays if at_points and n == len(data.points) else {}
        else:
            raise FileError(f"{source}: {key!r} is not known in a VTK file of polygons")
    return data


def _cells(words: _Words, key: str, n_points: int) -> list[Indices]:
    count, size = words.natural(key), words.natural(key)
    flat = words.numbers(size, key).astype(np.int64)
    cells, at = [], 0
    for k in range(count):
        corners = flat[at + 1 : at + 1 + flat[at]] if at < size else flat[:0]
        if len(corners) == 0 or len(corners) < flat[at] or corners.min() < 0 or corners.max() >= n_points:
            raise FileError(f"{words.source}: number {k} of the {key} is not made of the {n_points} points")
        cells.append(corners)
        at += 1 + len(corners)
    return cells


def _arrays(words: _Words, key: str, n: int) -> dict[str, Floats]:
    """The arrays of one section of data at points or cells."""
    name = words.next()
    if key == "FIELD":
        arrays = {}
        for _ in range(words.natural("arrays")):
            label, components, rows = words.next(), words.natural("components"), words.natural("values")
            words.next()
            values = words.numbers(components * rows, label)
            arrays[label] = values if components == 1 else values.reshape(rows, components)
        return arrays
    words.next()
    components = ATTRIBUTES.get(key, 1)
    if key == "SCALARS":
        if words.more() and words.words[words.at].isdigit():
            components = words.natural("components")
        if words.more() and words.words[words.at].upper() == "LOOKUP_TABLE":
            words.at += 2
    values = words.numbers(components * n, name)
    return {name: values if components == 1 else values.reshape(n, components)}
