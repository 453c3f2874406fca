"""Reader for slices in Carpet's HDF5 files of ADMBase.

Carpet writes a data set for every variable, iteration, refinement level and component, with its place and
time as attributes, into one file for each variable or group of variables, and for each process [1]_.

References
----------
.. [1] E. Schnetter, S. H. Hawley, I. Hawke, "Evolutions in 3D numerical relativity using fixed mesh
   refinement", Classical and Quantum Gravity 21 (2004), 1465-1488; the manual of the thorn CarpetIOHDF5.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.digest import unchanged
from isoembed.io.files import FileError
from isoembed.io.input_file import InputFile
from isoembed.relativity.series.grid_symmetry import IDENTITY, AxisMap
from isoembed.relativity.series.refined_grid import Component, beyond_ghosts, covering_grid
from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid
from isoembed.relativity.spacetimes.slice_file import GAMMA

PLACE = ("origin", "delta", "time")
SAMPLED = 8  # stride of the hashed planes in grid points


@dataclass(frozen=True)
class CarpetPart:
    """Data of an iteration in one file.

    Attributes
    ----------
    path : str
    thorn : str
        Name of the thorn in the names of the data sets.
    fields : tuple of str
        Fields in the file, among gxx ... kzz.
    tails : tuple of pairs of int and str
        Refinement levels, and the ends of the names of the data sets.
    has_ghosts : bool
        Whether the data include ghost zones.
    """

    path: str
    thorn: str
    fields: tuple[str, ...]
    tails: tuple[tuple[int, str], ...]
    has_ghosts: bool


@dataclass(frozen=True)
class CarpetSlice:
    """Slice of an iteration in files of Carpet, a `SliceSource`.

    Attributes
    ----------
    name : str
        Name for messages and reports.
    iteration : int
    parts : tuple of CarpetPart
    symmetry : tuple of AxisMap
        Symmetry of the run.
    flaw : str
        Reason why this slice cannot be read, if known.
    """

    name: str
    iteration: int
    parts: tuple[CarpetPart, ...]
    symmetry: tuple[AxisMap, ...] = (IDENTITY,)
    flaw: str = ""

    def digest(self) -> str:
        """Hash of the data sets of the iteration on all levels: their layout and every eighth plane.

        An iteration often has gigabytes of data, and a horizon needs a small part; hashing all of it
        would take seconds for each horizon.  Raises `FileError`: a file cannot be read, or changes meanwhile.
        """
        sha = hashlib.sha256(repr((self.iteration, self.symmetry, self.flaw)).encode())
        with _Reader(self) as reader:
            for part in self.parts:
                for name in part.fields:
                    for _, tail in part.tails:
                        data = reader.data_set(name, tail)
                        sha.update(repr((name, tail, part.has_ghosts, data.shape, data.dtype)).encode())
                        sha.update(np.ascontiguousarray(data[::SAMPLED]).data)
                        for key in PLACE if name == GAMMA[0] else ():
                            sha.update(np.asarray(data.attrs.get(key, ())).tobytes())
        return sha.hexdigest()

    def read(self, low: Floats, high: Floats) -> CartesianGrid:
        """Finest refinement level that covers the box; see `covering_grid`.

        Raises `FileError`: a file cannot be read or changes meanwhile, fields are missing, or no level covers
        the box.
        """
        if self.flaw:
            raise FileError(self.flaw)
        with _Reader(self) as reader:
            return covering_grid(reader, low, high)


class _Reader:
    """Data of an iteration as `RefinedData`, with one open file at a time."""

    def __init__(self, source: CarpetSlice) -> None:
        self.name, self.symmetry = source.name, source.symmetry
        self._iteration = source.iteration
        self._parts = {
            (name, tail): part for part in source.parts for name in part.fields for _, tail in part.tails
        }
        self._tails = sorted({pair for part in source.parts for pair in part.tails})
        self._path = ""
        self._file: Any = None
        self._closing = contextlib.ExitStack()

    def __enter__(self) -> _Reader:
        return self

    def __exit__(self, *exception: Any) -> None:
        self._closing.__exit__(*exception)

    @cached_property
    def fields(self) -> set[str]:
        return {name for name, _ in self._parts}

    @cached_property
    def levels(self) -> list[int]:
        return sorted({level for level, _ in self._tails})

    def components(self, level: int) -> list[Component]:
        return [self._component(tail) for at, tail in self._tails if at == level]

    def values(self, field: str, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        tail, ghosts = component.key
        data = self.data_set(field, tail)
        if data.shape != (
            expected := tuple(n + 2 * g for n, g in zip(component.shape, ghosts, strict=True))[::-1]
        ):
            raise FileError(
                f"{self._path}: {data.name[1:]} has {data.shape[::-1]} points, but gxx {expected[::-1]}"
            )
        i, j, k = beyond_ghosts(part, ghosts)
        rows = data[k, j]  # whole rows, as shorter pieces take ten times as long
        return np.asarray(rows[:, :, i], dtype=np.float64).T  # the files have [k, j, i]

    def data_set(self, field: str, tail: str) -> Any:
        """Data set; opens its file."""
        try:
            part = self._parts[field, tail]
        except KeyError:
            raise FileError(f"{self.name} has no {field} for{tail}") from None
        if part.path != self._path:
            self._closing.close()
            self._path, self._file = part.path, self._closing.enter_context(opened_unchanged(part.path))
        return self._file[f"{part.thorn}::{field} it={self._iteration}{tail}"]

    def _component(self, tail: str) -> Component:
        data = self.data_set(GAMMA[0], tail)
        if data.ndim != 3 or any(np.shape(data.attrs.get(key)) != (3,) for key in PLACE[:2]):
            raise FileError(f"{self._path}: {data.name[1:]} is not on a three-dimensional grid")
        origin, spacing = (np.asarray(data.attrs[key], dtype=np.float64) for key in PLACE[:2])
        ghosts = np.zeros(3, dtype=np.int64)
        if self._parts[GAMMA[0], tail].has_ghosts and "cctk_nghostzones" in data.attrs:
            ghosts += data.attrs["cctk_nghostzones"]
        shape = np.array(data.shape[::-1]) - 2 * ghosts
        return Component.of((tail, tuple(ghosts.tolist())), origin + spacing * ghosts, spacing, shape)


@contextlib.contextmanager
def opened_unchanged(path: str) -> Iterator[Any]:
    """Open an HDF5 file, and check that it is not modified while open."""
    with unchanged(path), InputFile(path) as file, file.hdf5() as root:
        yield root
