"""PLY, text and binary.  Read here, because properties and elements around the vertices and faces vary more
than a general library accepts; written in binary double precision with the data at the vertices.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from isoembed.io.files import FileError, Tables

CODES = {
    **{"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"},
    **{"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I"},
    **{"int64": "q", "uint64": "Q", "float": "f", "double": "d", "float32": "f", "float64": "d"},
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class Property:
    """A number or, with a code for its count, a list of numbers."""

    name: str
    code: str
    count_code: str = ""


@dataclass(frozen=True)
class Element:
    """A table of the file: its name, number of rows, and columns."""

    name: str
    size: int
    properties: tuple[Property, ...]


class Source(Protocol):
    """Where the numbers of the body come from."""

    def take(self, codes: str) -> Sequence[float]:
        """The next numbers, of these types; IndexError where there are none."""


class Text:
    """The numbers of a text body."""

    def __init__(self, body: bytes) -> None:
        self._words, self._next = body.split(), 0

    def take(self, codes: str) -> Sequence[float]:
        """The next numbers."""
        words = self._words[self._next : self._next + len(codes)]
        if len(words) < len(codes):
            raise IndexError
        self._next += len(codes)
        return [float(w) if code in "fd" else int(w) for w, code in zip(words, codes, strict=True)]


class Binary:
    """The numbers of a binary body."""

    def __init__(self, body: bytes, order: str) -> None:
        self._body, self._order, self._next = body, order, 0

    def take(self, codes: str) -> Sequence[float]:
        """The next numbers."""
        layout = self._order + codes
        end = self._next + struct.calcsize(layout)
        if end > len(self._body):
            raise IndexError
        numbers = struct.unpack_from(layout, self._body, self._next)
        self._next = end
        return numbers


def read(path: Path) -> Tables:
    """Read vertices and faces; all other elements and properties are left aside.

    Raises
    ------
    FileError
        The header cannot be understood, or the file is cut short.
    """
    data = path.read_bytes()
    end = re.search(rb"^end_header[ \t]*\r?\n", data, re.MULTILINE)
    if not data.startswith(b"ply") or end is None:
        raise FileError(f"{path} is not a PLY file: it has no header from 'ply' to 'end_header'")
    try:
        order, elements = _header(data[: end.start()].decode("utf-8", errors="replace"))
    except ValueError as error:
        raise FileError(f"{path}: the header says {str(error)!r}, which cannot be understood") from None
    source: Source = Binary(data[end.end() :], order) if order else Text(data[end.end() :])
    tables: dict[str, list[Sequence[float]]] = {"vertex": [], "face": []}
    for element in elements:
        for row in range(element.size if element.properties else 0):
            try:
                values = {p.name: _value(p, source) for p in element.properties}
                if element.name == "vertex":
                    tables["vertex"].append([values[axis][0] for axis in "xyz"])
                elif element.name == "face":
                    tables["face"].append(next(values[name] for name in CORNERS if name in values))
            except IndexError:
                raise FileError(f"{path} is cut short in {element.name} {row} of {element.size}") from None
            except (KeyError, StopIteration):
                wanted = "x, y and z" if element.name == "vertex" else " or ".join(CORNERS)
                raise FileError(f"{path}: {element.name} {row} has no {wanted}") from None
            except ValueError as error:
                raise FileError(f"{path}: cannot understand {element.name} {row}: {error}") from None
    vertices = np.array(tables["vertex"], dtype=np.float64).reshape(-1, 3)
    return {"vertices": vertices, "faces": [list(corners) for corners in tables["face"]]}


def write(path: Path, tables: Tables) -> None:
    """Write vertices, the data at them, and faces."""
    data = {key: value for key, value in tables.items() if key not in ("vertices", "faces")}
    columns = [*np.asarray(tables["vertices"]).T, *data.values()]
    names = ["x", "y", "z", *data]
    faces = np.asarray(tables["faces"])
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(columns[0])}"]
    head += [f"property double {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    rows["count"], rows["corners"] = 3, faces
    with path.open("wb") as file:
        file.write(("\n".join(head) + "\n").encode("ascii"))
        file.write(np.column_stack(columns).astype("<f8").tobytes())
        file.write(rows.tobytes())


def _value(column: Property, source: Source) -> Sequence[float]:
    if not column.count_code:
        return source.take(column.code)
    count = int(source.take(column.count_code)[0])
    if count < 0:
        raise ValueError(f"a list of {count} numbers")
    return source.take(column.code * count)


def _header(text: str) -> tuple[str, list[Element]]:
    """Byte order (empty for text) and elements; a ValueError holds the line that is not understood."""
    order, elements = None, list[Element]()
    for line in text.splitlines()[1:]:
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", name, _] if name in ORDERS:
                order = ORDERS[name]
            case ["element", name, size] if size.isdecimal():
                elements.append(Element(name, int(size), ()))
            case ["property", "list", count, code, name] if elements and count in CODES and code in CODES:
                _append(elements, Property(name, CODES[code], CODES[count]))
            case ["property", code, name] if elements and code in CODES:
                _append(elements, Property(name, CODES[code]))
            case _:
                raise ValueError(line.strip()[:60])
    if order is None:
        raise ValueError("nothing of its format")
    return order, elements


def _append(elements: list[Element], column: Property) -> None:
    last = elements[-1]
    elements[-1] = Element(last.name, last.size, (*last.properties, column))
