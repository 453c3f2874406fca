"""File formats: name ending, reader and writer."""

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
"""The vertices around each face: a table (F, 3) of triangles, or arrays of any lengths."""


@dataclass(frozen=True)
class Format:
    """A file format of surfaces.

    Attributes
    ----------
    ending : str
        Of the names of its files, in lower case, with its dot.
    read : callable
        Takes an `InputFile` and returns its arrays by their names: ``vertices`` (V, 3) and ``faces`` (F, 3),
        or ``faces``, ``edges`` (E, 2) and ``lengths`` (E,).  A surface in hyperbolic or spherical space has a
        ``curvature``, too, and the ``model`` that its coordinates are of, by default ``"conformal"``.
    write : callable or None
        Takes a path and such arrays, to which those of data at the vertices may be added, (V,) or vectors
        (V, 3), and single numbers.  None if it is only read.
    holds_metrics : bool
        It has a place for arrays of any name, so for metrics without vertices.
    repeats_vertices : bool
        The vertices of a face are its own; equal ones are merged when a file is read.
    holds_polygons : bool
        It has a place for faces that are not triangles: those of a polyhedron are written as a sequence of
        arrays, the vertices around each.
    """

    ending: str
    read: Callable[[InputFile], Tables]
    write: Callable[[Path, Tables], None] | None
    holds_metrics: bool = False
    repeats_vertices: bool = False
    holds_polygons: bool = False


def loaded(point: EntryPoint, kind: type[Kind]) -> Kind:
    """Object that the entry point of another package refers to.

    Raises
    ------
    FileError
        It cannot be loaded, or is not of this type.
    """
    try:
        found = point.load()
    except Exception as error:  # whatever a module of others raises
        why = f"{type(error).__name__}: {error}"
        raise FileError(f"the format {point.name!r} cannot be loaded from {point.value}: {why}") from error
    if not isinstance(found, kind):
        raise FileError(f"the format {point.name!r} is {point.value}, which is not a {kind.__name__}")
    return found


CURVATURES = ("mean_curvature", "gaussian_curvature")
"""Names of data at the vertices that are read with a surface."""


def at_vertices(tables: Tables) -> dict[str, NDArray[Any]]:
    """The data at the vertices among the arrays of a surface: without single numbers and words."""
    data = {key: np.asarray(value) for key, value in tables.items() if key not in ("vertices", "faces")}
    return {key: value for key, value in data.items() if value.ndim}


def of_the_whole(tables: Tables) -> dict[str, NDArray[Any]]:
    """The single numbers among the arrays of a surface."""
    data = {key: np.asarray(value) for key, value in tables.items() if key not in ("vertices", "faces")}
    return {key: value for key, value in data.items() if not value.ndim and value.dtype.kind in "iuf"}


def flattened(faces: Polygons) -> tuple[Indices, Indices]:
    """The corners of all faces one after the other, and how many each has."""
    if isinstance(faces, np.ndarray):
        return faces.ravel(), np.full(len(faces), faces.shape[1])
    return np.concatenate(faces), np.array([len(face) for face in faces])


def by_size(faces: Polygons) -> Iterator[Indices]:
    """Tables of consecutive faces with as many corners each."""
    if isinstance(faces, np.ndarray):
        yield faces
        return
    for _, some in groupby(faces, len):
        yield np.array(list(some))
