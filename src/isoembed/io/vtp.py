"""VTP files: polydata in VTK's XML format, in the encodings of `vtu`."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from isoembed.io.files import Tables
from isoembed.io.format import Format, flattened
from isoembed.io.input_file import InputFile
from isoembed.io.vtk import Polygons, surface
from isoembed.io.vtu import Source, read_pieces, write_piece

KINDS = {"Polys": "POLYGONS", "Strips": "TRIANGLE_STRIPS"}


def read(file: InputFile) -> Tables:
    """Read vertices, their curvatures, polygons and strips; other data, lines and points are ignored.

    Raises
    ------
    FileError
        The file has another format, or is truncated or damaged.
    """
    return read_pieces(file, "PolyData", _cells)


def _cells(file: InputFile, source: Source, piece: ElementTree.Element, n_points: int) -> Polygons:
    cells = {}
    for name, kind in KINDS.items():
        if int(piece.get(f"NumberOf{name}", "0")):
            corners, ends = (
                source.array(piece, f"{name}/DataArray[@Name='{part}']")
                for part in ("connectivity", "offsets")
            )
            cells[kind] = corners, ends
    return surface(file, cells, n_points)


def write(path: Path, tables: Tables) -> None:
    """Write polygons with the vertex data."""
    corners, sizes = flattened(tables["faces"])
    write_piece(path, tables, ("PolyData", "Polys"), (corners, np.cumsum(sizes)))


FORMAT = Format(".vtp", read, write, holds_polygons=True)
