"""The file formats by their endings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from isoembed.io import json, meshes, npz, obj, off, ply
from isoembed.io.files import Tables


@dataclass(frozen=True)
class Format:
    """How a format reads a file into named arrays and writes named arrays into a file."""

    read: Callable[[Path], Tables]
    write: Callable[[Path, Tables], None]


ARRAYS: dict[str, Format] = {
    ".npz": Format(npz.read, npz.write),
    ".json": Format(json.read, json.write),
}
"""Formats that hold any named arrays, so also metrics."""

MESHES: dict[str, Format] = {
    ".ply": Format(ply.read, ply.write),
    ".obj": Format(obj.read, obj.write),
    ".stl": Format(meshes.read_stl, meshes.write_stl),
    ".off": Format(off.read, off.write),
    ".vtk": Format(meshes.read_vtk, meshes.write_vtk),
    ".vtu": Format(meshes.read_vtu, meshes.write_vtu),
}
"""Formats that hold surfaces."""

FORMATS = ARRAYS | MESHES
METRIC_ENDINGS = tuple(ARRAYS)
MESH_ENDINGS = tuple(MESHES)
SURFACE_ENDINGS = tuple(FORMATS)
