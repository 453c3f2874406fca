"""Object File Format.  Read here, because headers, comments, colors and faces with more corners vary more
than a general library accepts.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, Tables

HEADERS = ("OFF", "COFF", "NOFF", "CNOFF", "STOFF")


def read(path: Path) -> Tables:
    """Read vertices and faces; colors, normals and textures are left aside.

    Raises
    ------
    FileError
        Naming the line that cannot be understood, or what is missing.
    """
    text = path.read_text(encoding="utf-8", errors="replace")
    lines = ((k, line.split("#")[0].split()) for k, line in enumerate(text.splitlines(), start=1))
    filled = ((k, words) for k, words in lines if words)
    number, words = next(filled, (1, [""]))
    if words[0] not in HEADERS or "BINARY" in words:
        raise FileError(f"{path} is not an OFF text file: it does not begin with {' or '.join(HEADERS)}")
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
        raise FileError(f"{path}, line {number}: cannot understand {' '.join(words)[:60]!r}") from None
    if len(vertices) < n_vertices or len(faces) < n_faces:
        raise FileError(
            f"{path} is cut short: it promises {n_vertices} vertices and {n_faces} faces, "
            f"but has {len(vertices)} and {len(faces)}"
        )
    return {"vertices": np.array(vertices, dtype=np.float64).reshape(-1, 3), "faces": faces}


def write(path: Path, tables: Tables) -> None:
    """Write vertices and faces; OFF has no place for data at the vertices."""
    vertices, faces = np.asarray(tables["vertices"]).tolist(), np.asarray(tables["faces"]).tolist()
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in vertices]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
