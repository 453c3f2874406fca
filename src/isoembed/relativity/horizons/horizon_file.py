"""Reader for horizon files of any format."""

import os
import re
from importlib.metadata import entry_points
from itertools import chain
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables
from isoembed.io.format import loaded
from isoembed.io.input_file import InputFile, opened
from isoembed.io.metric import read_tables
from isoembed.io.registry import MESH_ENDINGS
from isoembed.io.vtk import is_polydata, read_polydata
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity.horizons.ahfinderdirect import AHFINDERDIRECT
from isoembed.relativity.horizons.bhahaha import BHAHAHA
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape, check_solid, middle
from isoembed.relativity.horizons.grchombo import GRCHOMBO
from isoembed.relativity.horizons.grid_file import ARRAY_ENDINGS, METRIC_GRID
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.horizons.spectre import SPECTRE
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.surface.measures import volume

POINTS = ("points", "vertices")
CENTERS = ("center", "origin")
# Patterns of names in files without a surface, and explanations for the error message.
UNREAD = (
    (
        r"\bAh[A-Z]\.dir/",
        "; it looks like SpEC's Horizons.h5, which has the masses, spins and centers of horizons over time, "
        "but no surface: the coordinates of its points are in other files",
    ),
    (
        r"::\w+ it=\d+ tl=\d+",
        "; it looks like output of Carpet on its grids: a slice for geometry= is made of it by "
        "interpolation onto one Cartesian grid",
    ),
    (
        r"\.dat\b",
        "; it has no tables *_Ylm.dat with coefficients of surfaces: other tables *.dat hold histories of "
        "numbers",
    ),
)


def read_horizon(path: str | os.PathLike[str]) -> CoordinateShape | SurfaceData:
    """Read a horizon from a file of any format.

    Parameters
    ----------
    path : path
        File, optionally compressed (``.gz``), in a format recognized by content and ending: a shape file of
        AHFinderDirect or BHaHAHA; coordinates of GRChombo; surface data or harmonic coefficients of SpECTRE
        (see `read_spectre`); a metric on a grid, in arrays or a table (see `read_grid_data`); ``.npz``,
        ``.h5`` or ``.hdf5`` with ``points`` (V, 3) or ``x``, ``y``, ``z``, and optionally ``faces`` (F, 3),
        ``center`` (3,) and ``time``; polygons in a legacy VTK file of QuasiLocalMeasures; a closed mesh with
        coincident vertices merged; or a `HorizonFormat` of another package.

    Returns
    -------
    CoordinateShape or SurfaceData
        The metric, with k, p and K(., n) if available, or the coordinate shape if the file has no metric, as
        is usual; see `CoordinateShape.contents`.

    Raises
    ------
    FileError
        The file cannot be read, or holds no closed surface.
    InvalidMetric
        The metric or the triangulation in the file is invalid.
    """
    with opened(path) as file:
        added = (loaded(point, HorizonFormat) for point in entry_points(group="isoembed.horizon_formats"))
        for format_ in chain(FORMATS, added):
            if format_.recognizes(file):
                return format_.read(file)
        if file.ending in ARRAY_ENDINGS:
            there = file.contents
            kind = next((problem for names, problem in UNREAD if re.search(names, there)), "")
            raise FileError(
                f"{file} holds {there}: neither a metric (theta, phi, q_tt, q_tp, q_pp) nor points{kind}"
            )
    raise FileError(
        f"{file} is neither a file of AHFinderDirect or BHaHAHA (h.t*.ah*.gp), of GRChombo (coords_AH*.dat) "
        "or of SpECTRE (*_Ylm.dat), nor a table of a metric with theta, phi, q_tt, q_tp and q_pp above its "
        f"columns, nor a file with one of the endings {' '.join(ARRAY_ENDINGS)} {' '.join(MESH_ENDINGS)}"
    )


def _read_polydata(file: InputFile) -> CoordinateShape:
    data = read_polydata(file)
    if len(data.polygons) == 0:
        raise FileError(f"{file} has no polygons: it is not a surface")
    return CoordinateShape.star_shaped(data.points, str(file), polygons=data.polygons, fields=data.fields)


def _read_mesh(file: InputFile) -> CoordinateShape:
    try:
        tables = read_tables(file, merge=0.0)
    except InvalidMetric as error:
        raise InvalidMetric(f"{file}: {error}") from None
    return _shape_of(tables, str(file))


def _read_points(file: InputFile) -> CoordinateShape:
    shapes = _groups_of_points(file)
    if len(shapes) > 1:
        raise FileError(f"{file} holds {len(shapes)} surfaces, in the groups {', '.join(shapes)}: keep one")
    return _shape_of(next(iter(shapes.values())), str(file))


def _groups_of_points(file: InputFile) -> dict[str, Tables]:
    """Arrays of the groups that hold points."""
    groups = file.arrays if file.ending in ARRAY_ENDINGS else {}
    return {
        name: tables
        for name, tables in groups.items()
        if any(key in tables for key in POINTS) or all(key in tables for key in "xyz")
    }


def _shape_of(tables: Tables, source: str) -> CoordinateShape:
    """Surface from named arrays, with their triangles if there are any."""
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
    stored = next((tables[name] for name in CENTERS if name in tables), None)
    if stored is not None and np.shape(stored) != (3,):
        raise FileError(f"{source}: the center has the shape {np.shape(stored)}, not (3,)")
    center = None if stored is None else np.array(stored, dtype=np.float64)
    time = float(np.asarray(tables["time"]).reshape(())) if np.size(tables.get("time", ())) == 1 else None
    reserved = {*POINTS, *CENTERS, "x", "y", "z", "faces", "edges", "lengths", "time"}
    fields = {
        name: np.asarray(values, dtype=np.float64).ravel()
        for name, values in tables.items()
        if name not in reserved and np.asarray(values).dtype.kind in "iuf" and np.size(values) == len(points)
    }
    if "faces" not in tables:
        return CoordinateShape.star_shaped(points, source, center, fields=fields, time=time)
    check_solid(points, source)
    center = middle(points) if center is None else center
    faces = _outward(tables["faces"], points, source)
    return CoordinateShape(points, faces, center, time, source=source, fields=fields)


def _outward(faces: Any, points: Floats, source: str) -> Indices:
    try:
        triangulation = Triangulation(faces)
        triangulation.check_sphere()
    except InvalidMetric as error:
        raise InvalidMetric(f"{source}: {error}") from None
    table = triangulation.faces
    if triangulation.n_vertices != len(points):
        raise InvalidMetric(
            f"{source}: there are {len(points)} points, but {triangulation.n_vertices} in faces"
        )
    return table[:, ::-1].copy() if volume(table, points / np.max(np.abs(points))) < 0 else table


FORMATS = (
    BHAHAHA,  # before AHFinderDirect, which has the same ending
    AHFINDERDIRECT,
    HorizonFormat("VTK polydata", lambda file: is_polydata(file.head), _read_polydata),
    SPECTRE,
    GRCHOMBO,
    METRIC_GRID,
    HorizonFormat("points", lambda file: bool(_groups_of_points(file)), _read_points),
    HorizonFormat("mesh", lambda file: file.ending in MESH_ENDINGS, _read_mesh),
)
"""Built-in formats, in order of recognition."""
