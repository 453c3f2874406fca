"""Metrics from files and into files."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.io import json
from isoembed.io.files import FileError, Tables, Writer, check_ending, write_atomically
from isoembed.io.input_file import opened
from isoembed.io.registry import FORMATS, METRIC_ENDINGS, check_output, tables_writer
from isoembed.metric.given_mesh import triangle_mesh
from isoembed.metric.polyhedral import PolyhedralMetric


def read_metric(source: str | os.PathLike[str], *, merge: float | None = None) -> PolyhedralMetric:
    """Read a metric.

    Parameters
    ----------
    source : path or "-"
        ``.npz`` or ``.json`` with ``faces`` (F, 3), ``lengths`` (E,) and ``edges`` (E, 2), which may be
        left out where the lengths are in the order of `Triangulation.edges`; or with ``faces`` and
        ``vertices`` (V, 3); or a mesh.  Of vertices the lengths are taken and the coordinates thrown away.
        Faces between vertices may be polygons.  ``-`` reads JSON from standard input.
    merge : float, optional
        Vertices that are as near to one another, in mean edge lengths, become one: see
        `PolyhedralMetric.from_mesh`.  Formats with vertices of their own for every face (STL, glTF) have
        equal ones merged without being asked.

    Returns
    -------
    PolyhedralMetric

    Raises
    ------
    FileError
        The file cannot be read, or its ending is not known.
    InvalidMetric
        What it holds is not a metric.

    Warns
    -----
    MeshNote
        Vertices or faces are merged or left out, or polygons are not planar.
    """
    return metric_of(read_tables(source, merge))


def read_tables(source: str | os.PathLike[str], merge: float | None = None) -> Tables:
    """Read ``faces``, ``edges`` and ``lengths``, or ``vertices`` and triangles, in any of the formats."""
    if source == "-":
        return _tables(json.read_standard_input(), "standard input", merge)
    check_ending(source, FORMATS)
    with opened(source) as file:
        known = FORMATS[file.ending]
        tables = known.read(file)
    return _tables(tables, str(source), merge, repeated=known.repeats_vertices)


def metric_writer(path: str | os.PathLike[str], metric: PolyhedralMetric, **data: Floats) -> Writer:
    """Writer of a metric in the format of this ending; see `write_atomically`."""
    tables = {"faces": metric.faces, "edges": metric.edges, "lengths": metric.lengths, **data}
    return tables_writer(path, tables)


def write_metric(path: str | os.PathLike[str], metric: PolyhedralMetric) -> None:
    """Write ``faces``, ``edges`` and ``lengths`` as ``.npz`` or ``.json``.

    Raises
    ------
    FileError
        The ending is not known or the file cannot be written.
    """
    check_output(path, METRIC_ENDINGS)
    write_atomically({Path(path): metric_writer(path, metric)})


def metric_of(tables: Tables) -> PolyhedralMetric:
    """Metric of the arrays of a file."""
    if "lengths" in tables:
        return PolyhedralMetric(tables["faces"], tables["lengths"], tables.get("edges"))
    return PolyhedralMetric.from_mesh(tables["vertices"], tables["faces"])


def _tables(tables: Tables, name: str, merge: float | None, repeated: bool = False) -> Tables:
    """The arrays of a file of this name, checked; those of a mesh as points and triangles."""
    if "faces" not in tables or not ("lengths" in tables or "vertices" in tables):
        there = ", ".join(tables) if tables else "nothing"
        raise FileError(
            f"{name} holds {there}: a metric needs faces and lengths (with edges), or faces and vertices"
        )
    for key in ("faces", "edges", "lengths", "vertices"):
        if isinstance(tables.get(key), np.ndarray):
            _check_array(tables[key], key)
    if "lengths" in tables:
        if merge is not None:
            raise FileError(f"{name} holds lengths: vertices are merged where they are all that there is")
        return tables
    merge = 0.0 if merge is None and repeated else merge
    vertices, triangles = triangle_mesh(
        tables["vertices"], tables["faces"], merge, leave_out=True, repeated=repeated
    )
    return {"vertices": vertices, "faces": triangles}


def _check_array(array: np.ndarray[Any, Any], key: str) -> None:
    if array.ndim == 0:
        raise InvalidMetric(f"{key} is the single value {array.item()!r}, not an array")
    if array.dtype.kind not in "iuf":
        raise InvalidMetric(f"{key} has the type {array.dtype}, not numbers")
