"""Interface of a file format: name ending, reader and writer; loading of formats of other packages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from itertools import groupby
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Indices
from isoembed.io.files import FileError, Tables
from isoembed.io.input_file import InputFile

Kind = TypeVar("Kind")

Polygons = Indices | Sequence[Indices]
"""Vertices around each face: a table (F, 3) of triangles, or arrays of varying lengths."""


@dataclass(frozen=True)
class Format:
    """A file format of surfaces.

    Attributes
    ----------
    ending : str
        Suffix of file names in lower case, with its dot.
    read : callable
        Takes an `InputFile` and returns its arrays by name: ``vertices`` (V, 3) and ``faces`` (F, 3), or
        ``faces``, ``edges`` (E, 2) and ``lengths`` (E,).  A surface in hyperbolic or spherical space also has
        its ``curvature`` and the ``model`` of its coordinates, by default ``"conformal"``.
    write : callable or None
        Takes a path and such arrays, optionally with vertex data, (V,) or vectors (V, 3), and scalars.  None
        if the format is read-only.
    holds_metrics : bool
        The format stores arrays of any name, and thus metrics without vertices.
    repeats_vertices : bool
        Each face has its own vertices; equal ones are merged on reading.
    holds_polygons : bool
        The format stores faces other than triangles: those of a polyhedron are written as a sequence of
        arrays, the vertices around each.
    """

    ending: str
    read: Callable[[InputFile], Tables]
    write: Callable[[Path, Tables], None] | None
    holds_metrics: bool = False
    repeats_vertices: bool = False
    holds_polygons: bool = False


def loaded(point: EntryPoint, kind: type[Kind]) -> Kind:
    """Load the object of another package's entry point.

    Raises
    ------
    FileError
        The object cannot be loaded, or has another type.
    """
    try:
        found = point.load()
    except Exception as error:  # any error of a foreign module
        why = f"{type(error).__name__}: {error}"
        raise FileError(f"the format {point.name!r} cannot be loaded from {point.value}: {why}") from error
    if not isinstance(found, kind):
        raise FileError(f"the format {point.name!r} is {point.value}, which is not a {kind.__name__}")
    return found


CURVATURES = ("mean_curvature", "gaussian_curvature")
"""Names of vertex data read with a surface."""


def at_vertices(tables: Tables) -> dict[str, NDArray[Any]]:
    """Vertex data among the arrays of a surface, without scalars and strings."""
    data = {key: np.asarray(value) for key, value in tables.items() if key not in ("vertices", "faces")}
    return {key: value for key, value in data.items() if value.ndim}


def of_the_whole(tables: Tables) -> dict[str, NDArray[Any]]:
    """Numeric scalars among the arrays of a surface."""
    data = {key: np.asarray(value) for key, value in tables.items() if key not in ("vertices", "faces")}
    return {key: value for key, value in data.items() if not value.ndim and value.dtype.kind in "iuf"}


def flattened(faces: Polygons) -> tuple[Indices, Indices]:
    """Concatenated corners of all faces, and the number of corners of each."""
    if isinstance(faces, np.ndarray):
        return faces.ravel(), np.full(len(faces), faces.shape[1])
    return np.concatenate(faces), np.array([len(face) for face in faces])


def by_size(faces: Polygons) -> Iterator[Indices]:
    """Tables of consecutive faces with equal numbers of corners."""
    if isinstance(faces, np.ndarray):
        yield faces
        return
    for _, some in groupby(faces, len):
        yield np.array(list(some))
