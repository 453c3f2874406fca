"""STL, VTK and VTU by meshio, behind a fence: its readers fail in many ways and print to the screen."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables
from isoembed.io.text_scan import lines
from isoembed.surface.measures import face_normals

CORNER = "  vertex %r %r %r\n"
FACET = f"facet normal %r %r %r\n outer loop\n{3 * CORNER} endloop\nendfacet\n"


def read_stl(path: Path) -> Tables:
    """Read an STL file, text or binary; corners with exactly the same coordinates are one vertex."""
    from meshio import stl

    return _read(path, stl.read)


def read_vtk(path: Path) -> Tables:
    """Read a legacy VTK file with an unstructured grid."""
    from meshio import vtk

    return _read(path, vtk.read)


def read_vtu(path: Path) -> Tables:
    """Read a VTU file (VTK's XML with an unstructured grid)."""
    from meshio import vtu

    return _read(path, vtu.read)


def write_stl(path: Path, tables: Tables) -> None:
    """Write a text STL file: binary STL has single precision.  STL has no place for data at the vertices."""
    points, faces = np.asarray(tables["vertices"]), np.asarray(tables["faces"])
    scale = np.abs(points).max() or 1.0  # keeps tiny surfaces' normals from underflowing
    normals = face_normals(faces, points / scale)
    norms = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, norms, out=np.zeros_like(normals), where=norms > 0)
    with path.open("w", encoding="utf-8") as file:
        file.write("solid\n")
        file.writelines(lines(FACET, np.hstack([normals, points[faces].reshape(-1, 9)])))
        file.write("endsolid\n")


def write_vtk(path: Path, tables: Tables) -> None:
    """Write a binary legacy VTK file with the data at the vertices, in the version that all readers know."""
    from meshio import vtk

    vtk.write(str(path), _mesh(tables), fmt_version="4.2", binary=True)


def write_vtu(path: Path, tables: Tables) -> None:
    """Write a binary VTU file with the data at the vertices."""
    from meshio import vtu

    vtu.write(str(path), _mesh(tables), binary=True)


def _mesh(tables: Tables) -> Any:
    import meshio

    data = {key: value for key, value in tables.items() if key not in ("vertices", "faces")}
    faces = np.asarray(tables["faces"])
    return meshio.Mesh(tables["vertices"], [("triangle", faces)], point_data=data)


def _read(path: Path, reader: Callable[[Path], Any]) -> Tables:
    try:
        with _quiet():
            mesh = reader(path)
    except (Exception, SystemExit) as error:  # whatever meshio trips over, the file is to blame
        why = str(error).strip().splitlines()
        reason = f": {why[0]}" if why else ""
        raise FileError(f"{path} is not a readable {path.suffix[1:].upper()} file{reason}") from None
    if not mesh.cells:
        raise InvalidMetric("there are no faces")
    vertices = np.asarray(mesh.points, dtype=np.float64)
    if all(block.type == "triangle" for block in mesh.cells):
        return {"vertices": vertices, "faces": np.concatenate([block.data for block in mesh.cells])}
    faces: list[list[int]] = []
    for block in mesh.cells:
        if block.type not in ("triangle", "quad", "polygon"):
            raise InvalidMetric(f"cell {len(faces)} is a {block.type}, not a triangle")
        faces += [list(map(int, face)) for face in block.data]
    return {"vertices": vertices, "faces": faces}


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep meshio's words off the screen; data that ends early becomes an error."""
    silence = io.StringIO()
    with (
        contextlib.redirect_stdout(silence),
        contextlib.redirect_stderr(silence),
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
    ):
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", message="string or file could not be read")
        yield
