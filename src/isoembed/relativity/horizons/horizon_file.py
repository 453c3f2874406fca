"""Files of horizons, whichever code wrote them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric
from isoembed.io import npz
from isoembed.io.files import FileError, check_input, ending
from isoembed.io.hdf5 import HDF5_ENDINGS, groups_in, hdf5_file, numbers_in
from isoembed.io.polydata import is_polydata, parse_polydata
from isoembed.io.registry import MESHES
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity.horizons.ahfinderdirect import is_shape, read_ahfinderdirect, text_of
from isoembed.relativity.horizons.coordinate_shape import (
    CoordinateShape,
    check_solid,
    middle,
    triangulate_star_shaped,
)
from isoembed.relativity.horizons.grid_file import holds_metric, read_metric_grid
from isoembed.relativity.horizons.spectre import read_spectre, surfaces_in
from isoembed.smooth.grid_metric import GridMetric
from isoembed.surface.measures import volume

Floats = NDArray[np.float64]

POINTS = ("points", "vertices")
CENTERS = ("center", "origin")

__all__ = ["CoordinateShape", "read_horizon"]


def read_horizon(path: str | os.PathLike[str]) -> CoordinateShape | GridMetric:
    """Read a horizon from whatever file holds one.

    Parameters
    ----------
    path : path
        By its content and ending: a shape file of AHFinderDirect; ``.npz``, ``.h5`` or ``.hdf5`` with a
        metric on a grid (see `read_metric_grid`), with SpECTRE's surface data (see `read_spectre`), or with
        ``points`` (V, 3) or ``x``, ``y``, ``z``, and maybe ``faces`` (F, 3), ``center`` (3,) and ``time``;
        polygons in a legacy VTK file as QuasiLocalMeasures writes them; or a closed mesh of triangles.
        What is text may be compressed (``.gz``).

    Returns
    -------
    CoordinateShape or GridMetric
        The metric where the file has it; else the coordinate shape, which is all that most files have: its
        `CoordinateShape.contents` says so.

    Raises
    ------
    FileError
        The file cannot be read, or holds no closed surface.
    InvalidMetric
        What it holds as a metric, or as the triangles of a closed surface, is none.
    """
    path = Path(path)
    check_input(path)
    if ending(path) == ".npz":
        tables = npz.read(path)
        return read_metric_grid(path) if holds_metric(tables) else _shape_of(tables, str(path))
    if ending(path) in HDF5_ENDINGS:
        return _from_hdf5(path)
    zipped = ending(path) == ".gz"
    inner = Path(path.stem) if zipped else path
    if ending(inner) == ".vtk" or ending(inner) not in MESHES:
        # Binary files of other kinds are left to their readers.
        text = _text_or_none(path)
        if is_shape(text):
            return read_ahfinderdirect(path)
        if is_polydata(text):
            return _from_polydata(text, str(path))
    if ending(inner) == ".gp":
        return read_ahfinderdirect(path)
    if ending(inner) not in MESHES:
        raise FileError(
            f"{path} is neither a shape file of AHFinderDirect, nor of a kind that the endings "
            f".npz {' '.join(HDF5_ENDINGS)} {' '.join(MESHES)} tell"
        )
    if not zipped:
        return _shape_of(MESHES[ending(inner)].read(path), str(path))
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / inner.name
        plain.write_text(text_of(path), encoding="utf-8")
        return _shape_of(MESHES[ending(inner)].read(plain), str(path))


def _text_or_none(path: Path) -> str:
    try:
        return text_of(path)
    except FileError:
        return ""


def _from_hdf5(path: Path) -> CoordinateShape | GridMetric:
    with hdf5_file(path) as file:
        spectre = bool(surfaces_in(file))
        tables = {name: numbers_in(group) for name, group in groups_in(file).items()}
    if spectre:
        return read_spectre(path)
    if any(map(holds_metric, tables.values())):
        return read_metric_grid(path)
    shapes = {name: arrays for name, arrays in tables.items() if _holds_points(arrays)}
    if len(shapes) > 1:
        raise FileError(f"{path} holds {len(shapes)} surfaces, in the groups {', '.join(shapes)}: leave one")
    return _shape_of(next(iter(shapes.values()), tables[""]), str(path))


def _from_polydata(text: str, source: str) -> CoordinateShape:
    data = parse_polydata(text, source)
    if not data.polygons:
        raise FileError(f"{source} has no polygons: it is no surface")
    check_solid(data.points, source)
    center = middle(data.points)
    kept, faces = triangulate_star_shaped(data.points, center, source, data.polygons)
    fields = {name: values[kept] for name, values in data.fields.items()}
    return CoordinateShape(data.points[kept], faces, center, source=source, fields=fields)


def _holds_points(tables: Mapping[str, Any]) -> bool:
    return any(name in tables for name in POINTS) or all(name in tables for name in "xyz")


def _shape_of(tables: Mapping[str, Any], source: str) -> CoordinateShape:
    """The surface of named arrays: with its own triangles where it has them."""
    if not _holds_points(tables):
        there = ", ".join(tables) or "nothing"
        raise FileError(f"{source} holds {there}: neither a metric (theta, phi, q_tt, q_tp, q_pp) nor points")
    named = next((name for name in POINTS if name in tables), None)
    coordinates = [tables[name] for name in ([named] if named else "xyz")]
    if any(np.asarray(array).dtype.kind not in "iuf" for array in coordinates):
        raise FileError(f"{source}: the points are not numbers")
    shapes = [np.shape(array) for array in coordinates]
    if named and (len(shapes[0]) != 2 or shapes[0][1] != 3):
        raise FileError(f"{source}: {named} has the shape {shapes[0]}, not (V, 3)")
    if len(set(shapes)) > 1:
        raise FileError(f"{source}: x, y and z have the shapes {shapes[0]}, {shapes[1]} and {shapes[2]}")
    points = np.array(coordinates[0] if named else np.stack(coordinates, axis=-1), dtype=np.float64).reshape(
        -1, 3
    )
    given = next((tables[name] for name in CENTERS if name in tables), None)
    if given is not None and np.shape(given) != (3,):
        raise FileError(f"{source}: the center has the shape {np.shape(given)}, not (3,)")
    check_solid(points, source)
    center = middle(points) if given is None else np.array(given, dtype=np.float64)
    time = float(np.asarray(tables["time"]).reshape(())) if np.size(tables.get("time", ())) == 1 else None
    if "faces" in tables:
        kept, faces = np.arange(len(points)), _outward(tables["faces"], points, source)
    else:
        kept, faces = triangulate_star_shaped(points, center, source)
    taken = {*POINTS, *CENTERS, "x", "y", "z", "faces", "edges", "lengths", "time"}
    fields = {
        name: np.asarray(values, dtype=np.float64).ravel()[kept]
        for name, values in tables.items()
        if name not in taken and np.asarray(values).dtype.kind in "iuf" and np.size(values) == len(points)
    }
    return CoordinateShape(points[kept], faces, center, time, source=source, fields=fields)


def _outward(faces: Any, points: Floats, source: str) -> NDArray[np.int64]:
    try:
        triangulation = Triangulation(faces)
    except InvalidMetric as error:
        raise InvalidMetric(f"{source}: {error}") from None
    table = triangulation.faces
    if triangulation.n_vertices != len(points):
        raise InvalidMetric(
            f"{source}: there are {len(points)} points, but {triangulation.n_vertices} in faces"
        )
    return table[:, ::-1].copy() if volume(table, points / np.max(np.abs(points))) < 0 else table
