"""Reader for slices in CarpetX's openPMD files of ADMBaseX.

A file, which is a folder ``*.bp4`` or ``*.bp5``, holds iterations; these hold a mesh for each group of
variables and refinement level, as ``admbasex_metric_patch00_lev02``, with a record for each variable, and
CarpetX names its axes z, y, x [1]_.  They are read with openpmd-api, which kuibit brings along: kuibit 1.6.1
takes the axes for x, y, z.

References
----------
.. [1] A. Huebl et al., openPMD standard 1.1.0 (2018), doi:10.5281/zenodo.1167843; the thorn CarpetX.
"""

from __future__ import annotations

import contextlib
import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.digest import unchanged
from isoembed.io.files import FileError
from isoembed.relativity.series.carpet import SAMPLED
from isoembed.relativity.series.grid_symmetry import IDENTITY, AxisMap, symmetry_in
from isoembed.relativity.series.moment import ListedSlice
from isoembed.relativity.series.refined_grid import Component, covering_grid
from isoembed.relativity.series.source import SliceSource
from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid
from isoembed.relativity.spacetimes.slice_file import GAMMA, K

MESH = re.compile(r"(?P<thorn>admbasex)_(?:metric|curv)(?:_patch(?P<patch>\d+))?_(?:lev|rl)(?P<level>\d+)")
FILE = re.compile(r"(?!checkpoint).*\.bp[45]?")
DATA = "data.0"


def carpetx_slices(paths: Iterable[str | Path]) -> list[ListedSlice[SliceSource]]:
    """Slices in openPMD files of CarpetX; the last file counts for an iteration in several files.

    Raises `FileError`: there are such files, but none that can be read, or openpmd-api is not installed.

    Parameters
    ----------
    paths : iterable of path
        Files of a simulation, including those inside the folders.

    Returns
    -------
    list of ListedSlice
        Slices by iteration, without those of damaged files.
    """
    listed: dict[int, ListedSlice[SliceSource]] = {}
    flaws = []
    for path in paths:
        folder = Path(path).parent
        if Path(path).name == DATA and FILE.fullmatch(folder.name):
            try:
                listed |= {
                    each.iteration: each for each in _slices_in(str(folder)) if each.iteration is not None
                }
            except FileError as error:
                flaws.append(error)
    if flaws and not listed:
        raise flaws[0]
    return [listed[iteration] for iteration in sorted(listed)]


def _slices_in(path: str) -> Iterator[ListedSlice[SliceSource]]:
    with _opened(path) as series:
        for iteration, there in series.iterations.items():
            if any(MESH.fullmatch(mesh) for mesh in there.meshes):
                has_parameters = "AllParameters" in there.attributes
                symmetry = symmetry_in(there.get_attribute("AllParameters") if has_parameters else "")
                yield ListedSlice(
                    int(iteration), float(there.time), CarpetXSlice(path, int(iteration), symmetry)
                )


@dataclass(frozen=True)
class CarpetXSlice:
    """Slice of an iteration in an openPMD file of CarpetX, a `SliceSource`.

    Attributes
    ----------
    path : str
    iteration : int
    symmetry : tuple of AxisMap
        Symmetry of the run.
    """

    path: str
    iteration: int
    symmetry: tuple[AxisMap, ...] = (IDENTITY,)

    @property
    def name(self) -> str:
        """Name of the file, with the iteration."""
        return f"{self.path}, iteration {self.iteration}"

    def digest(self) -> str:
        """Hash of the layout of all data of the iteration, and of every eighth plane.

        Raises `FileError`: the file cannot be read, or changes meanwhile.
        """
        sha = hashlib.sha256(repr((self.iteration, self.symmetry)).encode())
        with _opened(self.path) as series:
            reader = _Reader(self, series)
            for level in reader.levels:
                sha.update(repr((level, reader.components(level))).encode())
                for name in sorted(reader.fields):
                    for plane in reader.planes(name, level):
                        sha.update(np.ascontiguousarray(plane).data)
        return sha.hexdigest()

    def read(self, low: Floats, high: Floats) -> CartesianGrid:
        """Finest refinement level that covers the box; see `covering_grid`.

        Raises `FileError`: the file cannot be read or changes meanwhile, fields are missing, or no level
        covers the box.
        """
        with _opened(self.path) as series:
            return covering_grid(_Reader(self, series), low, high)


class _Reader:
    """Data of an iteration as `RefinedData`."""

    def __init__(self, source: CarpetXSlice, series: Any) -> None:
        self.name, self.symmetry = source.name, source.symmetry
        self._series = series
        self._records: dict[tuple[str, int], tuple[Any, Any]] = {}
        for title, mesh in series.iterations[source.iteration].meshes.items():
            if match := MESH.fullmatch(title):
                if int(match["patch"] or 0) > 0:
                    raise FileError(
                        f"{self.name} has several patches of coordinates: only Cartesian ones are read"
                    )
                for record in mesh:
                    field = record.removeprefix(f"{match['thorn']}_")
                    self._records[field, int(match["level"])] = mesh, mesh[record]

    @cached_property
    def fields(self) -> set[str]:
        return {field for field, _ in self._records} & {*GAMMA, *K}

    @cached_property
    def levels(self) -> list[int]:
        return sorted({level for _, level in self._records})

    def components(self, level: int) -> list[Component]:
        mesh, record = self._record(GAMMA[0], level)
        axes = _axes(mesh)
        spacing = np.array(mesh.grid_spacing)
        first = np.array(mesh.grid_global_offset) + spacing * np.array(record.position)
        return [
            Component.of(
                tuple(chunk.offset),
                (first + spacing * np.array(chunk.offset))[axes],
                spacing[axes],
                np.array(chunk.extent)[axes],
            )
            for chunk in record.available_chunks()
        ]

    def values(self, field: str, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        mesh, record = self._record(field, level)
        axes = _axes(mesh)
        offset, extent = list(component.key), [0, 0, 0]
        for axis, along in zip(axes, part, strict=True):
            offset[axis] += along.start
            extent[axis] = along.stop - along.start
        values = record.load_chunk(offset, extent)
        self._series.flush()
        return np.asarray(values, dtype=np.float64).transpose(axes)

    def planes(self, field: str, level: int) -> list[Floats]:
        """Every eighth plane of all components, read together, because each request is slow."""
        _, record = self._record(field, level)
        planes = [
            record.load_chunk([first + k, *others], [1, *extent[1:]])
            for first, *others, extent in (
                (*chunk.offset, chunk.extent) for chunk in record.available_chunks()
            )
            for k in range(0, extent[0], SAMPLED)
        ]
        self._series.flush()
        return planes

    def _record(self, field: str, level: int) -> tuple[Any, Any]:
        try:
            return self._records[field, level]
        except KeyError:
            raise FileError(f"{self.name} has no {field} on the refinement level {level}") from None


def _axes(mesh: Any) -> list[int]:
    """Indices of the axes x, y and z of a mesh."""
    return [list(mesh.axis_labels).index(letter) for letter in "xyz"]


@contextlib.contextmanager
def _opened(path: str) -> Iterator[Any]:
    """Open an openPMD file, and check that it is not modified while open."""
    try:
        import openpmd_api
    except ImportError:
        raise FileError(
            f"reading {path} needs openpmd-api, which comes with kuibit: pip install kuibit h5py"
        ) from None
    with unchanged(Path(path, DATA)):
        series = None
        try:
            series = openpmd_api.Series(path, openpmd_api.Access.read_only)
            yield series
        except (RuntimeError, openpmd_api.Error) as error:
            raise FileError(
                f"{path} is not a readable openPMD file: {' '.join(str(error).split())}"
            ) from None
        finally:
            if series is not None:
                series.close()
