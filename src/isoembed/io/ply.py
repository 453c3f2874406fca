"""PLY files, text and binary, with any properties and elements besides vertices and faces.

Files are written in binary double precision with the vertex data.
"""

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, Tables
from isoembed.io.format import CURVATURES, Format, at_vertices, by_size
from isoembed.io.input_file import InputFile
from isoembed.io.strips import strip_triangles
from isoembed.io.text_scan import LONGEST
from isoembed.io.title_line import title_data, title_line

Columns = NDArray[Any]

CODES = {
    **{"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"},
    **{"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I"},
    **{"int64": "q", "uint64": "Q", "float": "f", "double": "d", "float32": "f", "float64": "d"},
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class Property:
    """A number or, with a type code for its count, a list of numbers."""

    name: str
    code: str
    count_code: str = ""


@dataclass(frozen=True)
class Element:
    """A table of the file: its name, number of rows, and columns."""

    name: str
    size: int
    properties: tuple[Property, ...]


class Body:
    """Numbers after the header, in text or in binary of either byte order."""

    def __init__(self, data: bytes, begin: int, order: str) -> None:
        self.order, self._data, self._next = order, data, begin
        self._words = [] if order else data[begin:].split()[::-1]

    def take(self, codes: str) -> Sequence[float]:
        """The next numbers of these types; IndexError at the end of the data."""
        if not self.order:
            words = [self._words.pop() for _ in codes]
            return [float(w) if code in "fd" else int(w) for w, code in zip(words, codes, strict=True)]
        begin, self._next = self._next, self._next + struct.calcsize(self.order + codes)
        if self._next > len(self._data):
            raise IndexError
        return struct.unpack_from(self.order + codes, self._data, begin)

    def value(self, column: Property) -> Sequence[float]:
        """The next number, or list of numbers, of a property."""
        if not column.count_code:
            return self.take(column.code)
        count = int(self.take(column.count_code)[0])
        if count < 0:
            raise ValueError(f"a list of {count} numbers")
        if count > len(self._data):
            raise IndexError
        return self.take(column.code * count)

    def take_all(self, element: Element) -> dict[str, Columns] | None:
        """All rows, by property; None unless all lists are as long as those of the first row."""
        begin = self._next
        try:
            first = [self.value(p) for p in element.properties]
        except (IndexError, ValueError):
            return None
        finally:
            self._next = begin
        fields: list[Any] = []
        counts: dict[str, int] = {}
        for k, p in enumerate(element.properties):
            if p.count_code:
                counts[f"count {k}"] = len(first[k])
                fields.append((f"count {k}", self.order + p.count_code))
            fields.append((f"value {k}", self.order + p.code, (len(first[k]),) if p.count_code else ()))
        layout = np.dtype(fields)
        if element.size * layout.itemsize > len(self._data) - begin:
            return None
        rows = np.frombuffer(self._data, layout, element.size, begin)
        if any((rows[name] != count).any() for name, count in counts.items()):
            return None
        self._next += rows.nbytes
        return {p.name: rows[f"value {k}"] for k, p in enumerate(element.properties)}


def read(file: InputFile) -> Tables:
    """Read vertices, their curvatures, faces and triangle strips; all other data are ignored.

    Raises
    ------
    FileError
        The header is invalid, or the file is truncated.
    """
    data = file.data
    end = re.search(rb"^end_header[ \t]*\r?\n", data, re.MULTILINE)
    if not data.startswith(b"ply") or end is None:
        raise FileError(f"{file} is not a PLY file: it has no header from 'ply' to 'end_header'")
    try:
        order, elements = _header(data[: end.start()].decode("utf-8", errors="replace"))
    except ValueError as error:
        raise FileError(f"{file}: the header says {str(error)!r}, which is not valid") from None
    body = Body(data, end.end(), order)
    tables: dict[str, list[Any]] = {"vertex": [], "face": [], "tristrips": []}
    for element in elements:
        together = _rows_together(element, body)
        rows = _rows(file, element, body) if together is None else together
        if element.name in tables:
            tables[element.name].append(rows)
    vertices, faces, strips = (
        parts[0] if len(parts) == 1 else list(chain(*parts)) for parts in tables.values()
    )
    if len(strips):
        faces = [*faces, *chain.from_iterable(_strip(strip) for strip in strips)]
    names = next(
        (_point_columns(element) for element in elements if element.name == "vertex"), ("x", "y", "z")
    )
    points = np.array(vertices, dtype=np.float64).reshape(-1, len(names))
    fields = dict(zip(names[3:], points.T[3:], strict=True))
    return {"vertices": points[:, :3], "faces": faces, **fields, **title_data(file.head)}


def write(path: Path, tables: Tables) -> None:
    """Write vertices, vertex data and faces."""
    columns, names = [*np.asarray(tables["vertices"]).T], ["x", "y", "z"]
    for key, value in at_vertices(tables).items():
        columns += [*np.atleast_2d(np.transpose(value))]
        names += [key] if value.ndim == 1 else [f"{key}_{axis}" for axis in "xyz"]
    faces = tables["faces"]
    count = "uchar" if max(map(len, faces)) < 256 else "int"
    head = ["ply", "format binary_little_endian 1.0"]
    head += [f"comment {line}"] if (line := title_line(tables)) else []
    head += [f"element vertex {len(columns[0])}"]
    head += [f"property double {name}" for name in names]
    head += [f"element face {len(faces)}", f"property list {count} int vertex_indices", "end_header"]
    with path.open("wb") as file:
        file.write(("\n".join(head) + "\n").encode("ascii"))
        file.write(np.column_stack(columns).astype("<f8").tobytes())
        for some in by_size(faces):
            corners = some.shape[1]
            rows = np.empty(len(some), [("count", "<" + CODES[count]), ("corners", "<i4", (corners,))])
            rows["count"], rows["corners"] = corners, some
            file.write(rows.tobytes())


def _rows_together(element: Element, body: Body) -> Columns | None:
    """Points of all vertices or corners of all faces, if their rows have a common layout."""
    lists = {p.name: bool(p.count_code) for p in element.properties}
    corners = next((name for name in CORNERS if name in lists), "")
    points = element.name == "vertex" and [lists.get(axis) for axis in "xyz"] == [False] * 3
    if not body.order or not (points or (element.name == "face" and lists.get(corners))):
        return None
    columns = body.take_all(element)
    if columns is None:
        return None
    return (
        np.column_stack([columns[name] for name in _point_columns(element)]) if points else columns[corners]
    )


def _point_columns(element: Element) -> tuple[str, ...]:
    """Names of the vertex coordinates and of the curvatures present."""
    numbers = {p.name for p in element.properties if not p.count_code}
    return ("x", "y", "z", *(name for name in CURVATURES if name in numbers))


def _rows(file: InputFile, element: Element, body: Body) -> list[list[float]]:
    """Points of the vertices or corners of the faces, row by row; empty for other elements."""
    rows = []
    for row in range(element.size if element.properties else 0):
        try:
            values = {p.name: body.value(p) for p in element.properties}
            if element.name == "vertex":
                rows.append([values[name][0] for name in _point_columns(element)])
            elif element.name in ("face", "tristrips"):
                rows.append(list(next(values[name] for name in CORNERS if name in values)))
        except IndexError:
            raise FileError(f"{file} is cut short in {element.name} {row} of {element.size}") from None
        except (KeyError, StopIteration):
            wanted = "x, y and z" if element.name == "vertex" else " or ".join(CORNERS)
            raise FileError(f"{file}: {element.name} {row} has no {wanted}") from None
        except ValueError as error:
            raise FileError(f"{file}: cannot understand {element.name} {row}: {error}") from None
    return rows


def _strip(corners: list[float]) -> list[list[float]]:
    """Triangles of consecutive strips, separated by -1."""
    numbers = np.array(corners, dtype=np.float64)  # some may not be indices
    parts = np.split(numbers, np.flatnonzero(numbers == -1))
    strips = (part[part != -1] for part in parts)
    return [t for strip in strips if len(strip) > 2 for t in strip_triangles(strip).tolist()]


def _header(text: str) -> tuple[str, list[Element]]:
    """Byte order (empty for text) and elements; a ValueError contains the invalid line."""
    order, elements = None, list[Element]()
    for line in text.splitlines()[1:]:
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", name, _] if name in ORDERS:
                order = ORDERS[name]
            case ["element", name, size] if size.isdecimal() and len(size) <= LONGEST:
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


FORMAT = Format(".ply", read, write, holds_polygons=True)
