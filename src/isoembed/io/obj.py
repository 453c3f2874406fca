"""Wavefront OBJ files: ``v`` and ``f`` lines."""

import re
from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format, by_size
from isoembed.io.input_file import InputFile
from isoembed.io.loops import scan_obj
from isoembed.io.text_scan import (
    lines,
    plain,
    triangles,
)
from isoembed.io.title_line import title_data, title_line

CONTINUED = re.compile(r"\\\r?\n")


def read(file: InputFile) -> Tables:
    """Read vertices and faces; textures, normals, groups and materials are ignored.

    Raises
    ------
    FileError
        A line is invalid; the message names it.
    """
    mesh = _read_plain(file.data) or _read_any(file, file.data.decode("utf-8-sig", errors="replace"))
    return {**mesh, **title_data(file.head)}


def _read_plain(data: bytes) -> Tables | None:
    """Triangles with absolute indices, in plain text."""
    text = plain(data)
    if text is None:
        return None
    tables = triangles(*scan_obj(text))
    beyond = tables is not None and tables["faces"].max(initial=-1) >= len(tables["vertices"])
    return None if beyond else tables  # the other reader reports the line


def _read_any(file: InputFile, content: str) -> Tables:
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    places = []
    for number, line in enumerate(CONTINUED.sub(" ", content).splitlines(), start=1):
        word, *entries = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                x, y, z = (float(entry) for entry in entries[:3])  # a weight or a color may follow
                vertices.append([x, y, z])
            elif word == "f":
                faces.append([_vertex(entry, len(vertices)) for entry in entries])
                places.append(number)
        except ValueError:
            raise FileError(f"{file}, line {number}: cannot understand {line.strip()[:60]!r}") from None
    for face, number in zip(faces, places, strict=True):
        if (last := max(face, default=-1)) >= (count := len(vertices)):
            raise FileError(
                f"{file}, line {number}: a face has vertex {last + 1}, but there are only {count} v lines"
            )
    return {"vertices": np.array(vertices, dtype=np.float64).reshape(-1, 3), "faces": faces}


def _vertex(entry: str, count: int) -> int:
    """Index of the vertex of a corner ``v/vt/vn``, numbered from 1 or backward from -1."""
    index = int(entry.split("/")[0])
    if index == 0 or index < -count:
        raise ValueError
    return index - 1 if index > 0 else count + index


def write(path: Path, tables: Tables) -> None:
    """Write vertices and faces; OBJ does not store vertex data."""
    with path.open("w", encoding="utf-8") as file:
        if line := title_line(tables):
            file.write(f"# {line}\n")
        file.writelines(lines("v %r %r %r\n", np.asarray(tables["vertices"])))
        for some in by_size(tables["faces"]):
            file.writelines(lines("f" + " %d" * some.shape[1] + "\n", some + 1))


FORMAT = Format(".obj", read, write, holds_polygons=True)
