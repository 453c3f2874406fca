"""Horizon files of SpECTRE: surface data in HDF5, in groups with the ending .vol."""

import numbers
import os
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Indices
from isoembed.io.files import AmbiguousFileError, FileError
from isoembed.io.hdf5 import HDF5_ENDINGS, numbers_in
from isoembed.io.input_file import InputFile, opened
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class ObservationThresholds:
    """Thresholds of choosing one of several observations."""

    time: float = threshold(1e-9, "relative", "Times that differ by at most this are the same.")


OBSERVATIONS = ObservationThresholds()
COORDINATES = tuple(f"InertialCoordinates_{axis}" for axis in "xyz")


def read_spectre(
    path: str | os.PathLike[str], surface: str | None = None, observation: float | str | None = None
) -> CoordinateShape:
    """Read one surface at one time.

    Parameters
    ----------
    path : path
        An HDF5 file with groups ``<surface>.vol/ObservationId<number>``, each with the inertial coordinates
        of the collocation points (Gauss-Legendre in theta, equiangular in phi) and scalars there.
    surface : str, optional
        Its name, with or without ``.vol``; may be left out if there is one only.
    observation : int, float or str, optional
        An int counts observations in the order of time, from 0, or from the end if it is negative; a float
        is the time itself; a str is the name of the group.  May be left out if there is one only.

    Returns
    -------
    CoordinateShape
        With the scalars as its fields, ``RicciScalar`` (twice the Gauss curvature) for one.

    Raises
    ------
    FileError
        The file cannot be read, or there is no such surface or observation, or several and none is chosen;
        the message lists those that are there.
    """
    tables, name, time = spectre_tables(path, surface, observation)
    extents = tables.get("total_extents")
    source = f"{path} ({name} at t = {time:g})"
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
    shape = CoordinateShape.star_shaped(points, source, polygons=quads, fields=fields, time=time)
    return replace(shape, name=name, source=str(path))


def spectre_tables(
    path: str | os.PathLike[str], surface: str | None = None, observation: float | str | None = None
) -> tuple[dict[str, NDArray[Any]], str, float]:
    """All numbers that a file has of one surface at one time, the name of the surface, and the time.

    Parameters and errors are those of `read_spectre`.
    """
    with opened(path) as given, given.hdf5() as file:
        group, name = _chosen_surface(_surfaces(file), surface, str(path))
        observed, time = _chosen_observation(group, observation, f"{path}: {name}")
        return numbers_in(observed, path), name, time


def spectre_times(path: str | os.PathLike[str]) -> dict[str, list[tuple[float, str]]]:
    """Times of the surfaces of a file, in order, and the names of their groups, by the names of the surfaces.

    There are none in a file of another kind.

    Raises
    ------
    FileError
        It cannot be read.
    """
    with opened(path) as given, given.hdf5() as file:
        return {
            name: [(time, str(one.name).rsplit("/", 1)[1]) for time, one in _observations(group)]
            for name, group in _surfaces(file).items()
        }


def _recognizes(file: InputFile) -> bool:
    if file.ending not in HDF5_ENDINGS:
        return False
    with file.hdf5() as contents:
        return bool(_surfaces(contents))


def _surfaces(file: Any) -> dict[str, Any]:
    """The groups of surface data in an open file, by their names without ``.vol``; nothing in them."""
    found: dict[str, Any] = {}
    seen, left = {file}, [file]  # a group may be in itself
    while left:
        above = left.pop()
        for name in _inside(above):
            group = above[name]
            if not hasattr(group, "items") or group in seen:
                continue
            seen.add(group)
            if not name.endswith(".vol"):
                left.append(group)
            elif group.attrs.get("dimension", 2) == 2:
                found[group.name.strip("/").removesuffix(".vol")] = group
    return dict(sorted(found.items()))


def _quads(extents: NDArray[np.integer]) -> Indices:
    """The quadrilaterals of the grid, theta running fastest: the file's own are not oriented alike."""
    i, j = np.meshgrid(np.arange(int(extents[0]) - 1), np.arange(int(extents[1])))
    here, there = i + int(extents[0]) * j, i + int(extents[0]) * ((j + 1) % int(extents[1]))
    return np.stack([here, here + 1, there + 1, there], axis=-1).reshape(-1, 4)


def _chosen_surface(surfaces: dict[str, Any], surface: str | None, source: str) -> tuple[Any, str]:
    there = ", ".join(surfaces) or "nothing"
    name = surface.removesuffix(".vol") if surface is not None else next(iter(surfaces), "")
    if surface is None and len(surfaces) > 1:
        raise AmbiguousFileError(f"{source} holds several surfaces: choose one of {there}", "surface")
    if name not in surfaces:
        wanted = f"no surface {name}" if surface is not None else "no groups *.vol"
        raise FileError(f"{source} holds {wanted}, but {there}")
    return surfaces[name], name


def _chosen_observation(group: Any, observation: float | str | None, source: str) -> tuple[Any, float]:
    if isinstance(observation, str):
        if observation not in group or "observation_value" not in group[observation].attrs:
            raise FileError(f"{source} holds no observation {observation}")
        return group[observation], float(group[observation].attrs["observation_value"])
    timed = _observations(group)
    times = np.array([time for time, _ in timed])
    listed = ", ".join(f"{time:g}" for time in times) or "none"
    if observation is None:
        if not timed:
            raise FileError(f"{source} holds no observation: no group in it has an observation_value")
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
        near = np.flatnonzero(np.abs(times - observation) <= OBSERVATIONS.time * np.abs(times))
        if len(near) == 0:
            raise FileError(f"{source} holds no observation t = {observation:g}, but t = {listed}")
        k = int(near[0])
    return timed[k][1], timed[k][0]


def _inside(group: Any) -> list[str]:
    """Names in a group, but for links to somewhere else and the bytes that some are in damaged files."""
    return [
        name for name in group if isinstance(name, str) and not hasattr(group.get(name, getlink=True), "path")
    ]


def _observations(group: Any) -> list[tuple[float, Any]]:
    """The times of a surface and their groups, in order."""
    there = (group[name] for name in _inside(group))
    timed = ((item.attrs.get("observation_value"), item) for item in there)
    return sorted(((float(time), item) for time, item in timed if time is not None), key=lambda pair: pair[0])


SPECTRE = HorizonFormat("SpECTRE", _recognizes, read_spectre)
