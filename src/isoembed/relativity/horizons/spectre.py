"""Reader for SpECTRE's surface data and harmonic coefficients of horizons.

Surface data are in HDF5 groups ``<surface>.vol``, coefficients in HDF5 datasets ``<surface>_Ylm.dat`` or in
text files with such names.
"""

import contextlib
import numbers
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Indices
from isoembed.io.files import AmbiguousFileError, FileError
from isoembed.io.hdf5 import HDF5_ENDINGS, enumerated, numbers_in
from isoembed.io.input_file import InputFile, opened
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.horizons.spectre_harmonics import (
    MONOPOLE,
    HarmonicTable,
    harmonic_shape,
    is_harmonic_text,
)

COORDINATES = tuple(f"InertialCoordinates_{axis}" for axis in "xyz")
VOLUME, HARMONICS, TEXT = ".vol", "_Ylm.dat", ".dat"
SPECTRE_ENDINGS = (*HDF5_ENDINGS, TEXT)


@dataclass(frozen=True)
class SurfaceGroup:
    """Surface in a group ``<surface>.vol``, with a subgroup ``ObservationId<number>`` for each time.

    Attributes
    ----------
    group : h5py.Group
    path : str
        Name of the file, for messages.
    """

    group: Any
    path: str

    def observations(self) -> list[tuple[float, str]]:
        """Times in increasing order, and the names of their groups."""
        timed = ((self.time(name), name) for name in _inside(self.group))
        return sorted(((time, name) for time, name in timed if time is not None), key=lambda pair: pair[0])

    def time(self, name: str) -> float | None:
        """Time of an observation; None if there is none of that name."""
        time = self.group[name].attrs.get("observation_value") if name in self.group else None
        return None if time is None else float(time)

    def tables(self, name: str) -> dict[str, NDArray[Any]]:
        """Arrays of an observation."""
        return numbers_in(self.group[name], self.path)


def read_spectre(
    path: str | os.PathLike[str], surface: str | None = None, observation: float | str | None = None
) -> CoordinateShape:
    """Read one surface at one time.

    Parameters
    ----------
    path : path
        HDF5 file with groups ``<surface>.vol/ObservationId<number>``, which hold the inertial coordinates of
        the collocation points (Gauss-Legendre in theta, equiangular in phi) and scalars; or with datasets
        ``<surface>_Ylm.dat``, whose rows are the harmonic coefficients of a surface in the inertial frame at
        one time each; or such a table as text, with ``# [k] <name>`` for each column.  Points take precedence
        if a file has a surface in both forms.
    surface : str, optional
        Name of the surface, with or without ``.vol`` or ``_Ylm.dat``; optional if there is only one.
    observation : int, float or str, optional
        Index of the observation in order of time, negative from the end (int); its time (float); or the name
        of its group or number of its row (str).  Optional if there is only one.

    Returns
    -------
    CoordinateShape
        Its fields are the scalars, such as ``RicciScalar`` (twice the Gaussian curvature).  Harmonic
        coefficients are evaluated with twofold oversampling in each direction.

    Raises
    ------
    FileError
        The file cannot be read, there is no such surface or observation, or there are several and none is
        chosen; the message lists the choices.
    """
    tables, name, time = spectre_tables(path, surface, observation)
    source = f"{path} ({name} at t = {time:g})"
    read = harmonic_shape if MONOPOLE in tables else _shape_of_points
    return replace(read(tables, source, time), name=name, source=str(path))


def spectre_tables(
    path: str | os.PathLike[str], surface: str | None = None, observation: float | str | None = None
) -> tuple[dict[str, NDArray[Any]], str, float]:
    """Arrays of one surface at one time, the name of the surface, and the time.

    Parameters and exceptions are those of `read_spectre`.
    """
    with _surfaces(path) as surfaces:
        found, name = _chosen_surface(surfaces, surface, str(path))
        observed, time = _chosen_observation(found, observation, f"{path}: {name}")
        return found.tables(observed), name, time


def spectre_times(path: str | os.PathLike[str]) -> dict[str, list[tuple[float, str]]]:
    """Times in increasing order and names of the observations in a file, by surface.

    The result is empty for files of other formats.  Raises `FileError`: the file cannot be read.
    """
    with _surfaces(path) as surfaces:
        return {name: found.observations() for name, found in surfaces.items()}


def surface_name(name: str) -> str:
    """Name of a surface without the ending of its storage format."""
    return name.removesuffix(VOLUME).removesuffix(HARMONICS)


def _recognizes(file: InputFile) -> bool:
    if file.ending == TEXT:
        return is_harmonic_text(file)
    if file.ending not in HDF5_ENDINGS:
        return False
    with _surfaces(file) as surfaces:
        return bool(surfaces)


@contextlib.contextmanager
def _surfaces(path: str | os.PathLike[str]) -> Iterator[dict[str, SurfaceGroup | HarmonicTable]]:
    """Surfaces in a file by name, readable inside the context; empty for files of other formats."""
    with opened(path) as source:
        if source.ending == TEXT:
            name = surface_name(source.path.name.removesuffix(".gz"))
            yield {name: HarmonicTable.in_text(source)} if is_harmonic_text(source) else {}
            return
        with source.hdf5() as file:
            yield dict(sorted(_surfaces_in(file, str(source)).items()))


def _surfaces_in(file: Any, path: str) -> dict[str, SurfaceGroup | HarmonicTable]:
    """Surfaces in an open HDF5 file; points take precedence over coefficients of the same name."""
    groups: dict[str, SurfaceGroup] = {}
    tables: dict[str, HarmonicTable] = {}
    visited, left = {file}, [file]  # groups may contain themselves
    while left:
        above = left.pop()
        for name in _inside(above):
            item = above[name]
            if item in visited:
                continue
            visited.add(item)
            called = surface_name(item.name.strip("/"))
            if not hasattr(item, "items"):
                if name.endswith(HARMONICS) and (table := HarmonicTable.in_dataset(item)):
                    tables[called] = table
            elif not name.endswith(VOLUME):
                left.append(item)
            elif item.attrs.get("dimension", 2) == 2:
                groups[called] = SurfaceGroup(item, path)
    return tables | groups


def _shape_of_points(tables: dict[str, NDArray[Any]], source: str, time: float) -> CoordinateShape:
    """Surface through the collocation points of an observation."""
    extents = tables.get("total_extents")
    absent = [axis for axis in COORDINATES if axis not in tables]
    if absent:
        raise FileError(f"{source} has no {absent[0]}: it is not a surface in space")
    sizes = [tables[axis].size for axis in COORDINATES]
    if len(set(sizes)) > 1 or (extents is not None and (len(extents) != 2 or np.prod(extents) != sizes[0])):
        grid = " x ".join(map(str, extents)) if extents is not None else "one"
        raise FileError(f"{source} has {sizes} coordinates x, y and z and not the points of {grid} grid")
    points = np.column_stack([tables[axis].ravel() for axis in COORDINATES]).astype(np.float64)
    fields = {
        key: value.astype(np.float64)
        for key, value in tables.items()
        if key not in COORDINATES and value.dtype.kind == "f" and value.shape == (len(points),)
    }
    quads = _quads(extents).tolist() if extents is not None else ()
    return CoordinateShape.star_shaped(points, source, polygons=quads, fields=fields, time=time)


def _quads(extents: NDArray[np.integer]) -> Indices:
    """Quadrilaterals of the grid, theta the fastest index; those in files are not consistently oriented."""
    i, j = np.meshgrid(np.arange(int(extents[0]) - 1), np.arange(int(extents[1])))
    here, there = i + int(extents[0]) * j, i + int(extents[0]) * ((j + 1) % int(extents[1]))
    return np.stack([here, here + 1, there + 1, there], axis=-1).reshape(-1, 4)


def _chosen_surface(surfaces: dict[str, Any], surface: str | None, source: str) -> tuple[Any, str]:
    there = ", ".join(surfaces) or "nothing"
    name = surface_name(surface) if surface is not None else next(iter(surfaces), "")
    if surface is None and len(surfaces) > 1:
        raise AmbiguousFileError(f"{source} holds several surfaces: choose one of {there}", "surface")
    if name not in surfaces:
        wanted = f"no surface {name}" if surface is not None else "no groups *.vol or tables *_Ylm.dat"
        raise FileError(f"{source} holds {wanted}, but {there}")
    return surfaces[name], name


def _chosen_observation(
    found: SurfaceGroup | HarmonicTable, observation: float | str | None, source: str
) -> tuple[str, float]:
    """Name of an observation, and its time."""
    if isinstance(observation, str):
        if (time := found.time(observation)) is None:
            raise FileError(f"{source} holds no observation {observation}")
        return observation, time
    timed = found.observations()
    times = np.array([time for time, _ in timed])
    listed = enumerated([f"{time:g}" for time in times]) or "none"
    if observation is None:
        if not timed:
            raise FileError(f"{source} holds no observation: there is no time in it")
        if len(timed) > 1:
            raise AmbiguousFileError(
                f"{source} holds {len(timed)} observations: choose one of t = {listed}", "observation"
            )
        k = 0
    elif isinstance(observation, numbers.Integral):
        if not -len(timed) <= observation < len(timed):
            raise FileError(f"{source} holds no observation {observation}, but {len(timed)}, t = {listed}")
        k = int(observation)
    else:
        near = np.flatnonzero(np.abs(times - observation) <= 1e-9 * np.abs(times))  # rounding of times
        if len(near) == 0:
            raise FileError(f"{source} holds no observation t = {observation:g}, but t = {listed}")
        k = int(near[0])
    return timed[k][1], timed[k][0]


def _inside(group: Any) -> list[str]:
    """Names in a group, without external links and names that are bytes, as in damaged files."""
    return [
        name for name in group if isinstance(name, str) and not hasattr(group.get(name, getlink=True), "path")
    ]


SPECTRE = HorizonFormat("SpECTRE", _recognizes, read_spectre)
