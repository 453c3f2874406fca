"""Object File Format (.off), as text."""

import re
from itertools import islice
from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format, by_size
from isoembed.io.input_file import InputFile
from isoembed.io.loops import scan_off
from isoembed.io.text_scan import (
    lines,
    plain,
    triangles,
)
from isoembed.io.title_line import title_data, title_line
from isoembed.typed_numbers import EXPONENT

HEADERS = tuple(f"{st}{c}{n}OFF" for st in ("", "ST") for c in ("", "C") for n in ("", "N"))
HEADER = re.compile(rb"(?:ST)?C?N?OFF\s+(?:#[^\n]*\n\s*)*(\d{1,18})[ \t]+(\d{1,18})(?:[ \t]+\d+)?[ \t]*\r?\n")


def read(file: InputFile) -> Tables:
    """Read vertices and faces; colors, normals, textures, and faces of one or two corners are ignored.

    Raises
    ------
    FileError
        A line is invalid, or data are missing; the message names the line or the counts.
    """
    mesh = _read_plain(file.data)
    if mesh is None:
        content = file.data.decode("utf-8-sig", errors="replace")
        mesh = _read_any(file, EXPONENT.sub("e", content))
    return {**mesh, **title_data(file.head)}


def _read_plain(data: bytes) -> Tables | None:
    """Triangles in plain text, with a header on lines of its own."""
    header = HEADER.match(data)
    text = plain(data)
    if header is None or text is None:
        return None
    n_vertices, n_faces = int(header[1]), int(header[2])
    if n_vertices + n_faces > len(data):
        return None
    coordinates, faces = scan_off(text[header.end() :], n_vertices, n_faces)
    return triangles(coordinates, n_vertices, faces)


def _read_any(file: InputFile, content: str) -> Tables:
    split = ((k, line.split("#")[0].split()) for k, line in enumerate(content.splitlines(), start=1))
    filled = ((k, words) for k, words in split if words)
    number, words = next(filled, (1, [""]))
    if words[0] not in HEADERS or "BINARY" in words:
        raise FileError(f"{file} is not an OFF text file: it does not begin with {' or '.join(HEADERS)}")
    try:
        number, words = (number, words[1:]) if len(words) > 1 else next(filled, (number, []))
        n_vertices, n_faces = (int(word) for word in words[:2])
        vertices = []
        for number, words in islice(filled, n_vertices):  # noqa: B007 - for the message
            x, y, z = (float(word) for word in words[:3])
            vertices.append([x, y, z])
        faces = []
        for number, words in islice(filled, n_faces):  # noqa: B007 - for the message
            corners = [int(word) for word in words[1 : 1 + int(words[0])]]
            if len(corners) != int(words[0]):
                raise ValueError
            faces.append(corners)
    except ValueError:
        raise FileError(f"{file}, line {number}: cannot understand {' '.join(words)[:60]!r}") from None
    if len(vertices) < n_vertices or len(faces) < n_faces:
        raise FileError(
            f"{file} is cut short: it promises {n_vertices} vertices and {n_faces} faces, "
            f"but has {len(vertices)} and {len(faces)}"
        )
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    return {"vertices": points, "faces": [corners for corners in faces if len(corners) not in (1, 2)]}


def write(path: Path, tables: Tables) -> None:
    """Write vertices and faces; OFF does not store vertex data."""
    vertices, faces = np.asarray(tables["vertices"]), tables["faces"]
    with path.open("w", encoding="utf-8") as file:
        file.write("OFF\n")
        if line := title_line(tables):
            file.write(f"# {line}\n")
        file.write(f"{len(vertices)} {len(faces)} 0\n")
        file.writelines(lines("%r %r %r\n", vertices))
        for some in by_size(faces):
            file.writelines(lines(f"{some.shape[1]}" + " %d" * some.shape[1] + "\n", some))


FORMAT = Format(".off", read, write, holds_polygons=True)
