"""STL files, text and binary: triangles without shared vertices.

Reading 100,000 triangles takes 0.5 s from text and 0.09 s from binary; meshio takes 1.1 and 0.56 s.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.loops import scan_stl
from isoembed.io.text_scan import lines, numbers
from isoembed.io.title_line import title_data, title_line
from isoembed.surface.measures import face_normals

CORNER = "  vertex %r %r %r\n"
FACET = f"facet normal %r %r %r\n outer loop\n{3 * CORNER} endloop\nendfacet\n"
HEADER = 84  # bytes of a binary file before the triangles
TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
BOM = b"\xef\xbb\xbf"


def read(file: InputFile) -> Tables:
    """Read triangles, each with its own vertices.

    Raises
    ------
    FileError
        The file is not STL.
    """
    data = file.data
    count = int.from_bytes(data[HEADER - 4 : HEADER], "little")
    rest = len(data) - HEADER - count * TRIANGLE.itemsize
    # Binary files may begin with "solid", too, but below 2**24 triangles their count has a zero byte.
    is_text = data.removeprefix(BOM).lstrip()[:5].lower() == b"solid" and b"\0" not in data[:HEADER]
    if rest == 0 or (rest > 0 and count and not is_text):  # some programs append a line feed or a footer
        return _apart(np.frombuffer(data, TRIANGLE, count, HEADER)["corners"].reshape(-1, 3))
    if not is_text:
        raise FileError(
            f"{file} is not a readable STL file: it does not begin with 'solid', and is not binary STL"
            + (f", which would have {count} triangles in {len(data) - rest} bytes" if count else "")
        )
    text = data.removeprefix(BOM).replace(b"\r", b"\n") + b"\n"
    coordinates, corners, facets = scan_stl(np.frombuffer(text, dtype=np.uint8))
    values = numbers(coordinates)
    if values is None or values.size != 3 * corners:
        raise FileError(f"{file} is not a readable STL file: a vertex is not three numbers")
    if corners != 3 * facets:
        raise FileError(f"{file} is not a readable STL file: it has {facets} facets, but {corners} corners")
    return {**_apart(values.reshape(-1, 3)), **title_data(file.head)}


def write(path: Path, tables: Tables) -> None:
    """Write a text STL file, as binary STL has single precision; STL does not store vertex data."""
    points, faces = np.asarray(tables["vertices"]), np.asarray(tables["faces"])
    scale = np.abs(points).max() or 1.0  # prevents underflow of the normals of tiny surfaces
    normals = face_normals(faces, points / scale)
    norms = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, norms, out=np.zeros_like(normals), where=norms > 0)
    with path.open("w", encoding="utf-8") as file:
        file.write(f"solid {title_line(tables)}".rstrip() + "\n")
        file.writelines(lines(FACET, np.hstack([normals, points[faces].reshape(-1, 9)])))
        file.write("endsolid\n")


def _apart(corners: NDArray) -> Tables:
    """Triangles, each with its own vertices."""
    return {"vertices": corners.astype(np.float64), "faces": np.arange(len(corners)).reshape(-1, 3)}


FORMAT = Format(".stl", read, write, repeats_vertices=True)
