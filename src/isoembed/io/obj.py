"""Wavefront OBJ: ``v`` and ``f`` lines.  Read here, because negative indices, colored vertices and faces
with more corners need better answers than a general library gives.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, Tables


def read(path: Path) -> Tables:
    """Read vertices and faces; textures, normals, groups and materials are left aside.

    Raises
    ------
    FileError
        Naming the line that cannot be understood.
    """
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        word, *entries = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                x, y, z = (float(entry) for entry in entries[:3])  # a weight or a color may follow
                vertices.append([x, y, z])
            elif word == "f":
                faces.append([_vertex(entry, len(vertices)) for entry in entries])
        except ValueError:
            raise FileError(f"{path}, line {number}: cannot understand {line.strip()[:60]!r}") from None
    return {"vertices": np.array(vertices, dtype=np.float64).reshape(-1, 3), "faces": faces}


def _vertex(entry: str, count: int) -> int:
    """Index of the vertex of a corner ``v/vt/vn``: from 1 at the beginning, or from -1 at the last one."""
    index = int(entry.split("/")[0])
    if index == 0 or index < -count:
        raise ValueError
    return index - 1 if index > 0 else count + index


def write(path: Path, tables: Tables) -> None:
    """Write vertices and faces; OBJ has no place for data at the vertices."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(tables["vertices"]).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(tables["faces"]) + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
