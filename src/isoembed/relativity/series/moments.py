"""Time steps of a series from files and folders: horizons, and their slices if there are any."""

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io.files import FileError, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS, enumerated
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.spectre import surface_name
from isoembed.relativity.series.carpet_files import carpet_slices
from isoembed.relativity.series.carpetx import carpetx_slices
from isoembed.relativity.series.file_names import is_pattern, listing_of, natural_order
from isoembed.relativity.series.matching import matched, ordered
from isoembed.relativity.series.moment import ListedSlice, Moment
from isoembed.relativity.series.shape_files import SHAPE, shape_files_in, shapes_in_files
from isoembed.relativity.series.slice_files import slices_in_file, slices_in_folder, slices_of_pattern
from isoembed.relativity.series.source import HeldSlice, MissingSlice, SliceSource
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

GRIDS = (*HDF5_ENDINGS, ".bp", ".bp4", ".bp5")  # endings of three-dimensional data of the Einstein Toolkit
SHAPES = re.compile(r"h\.t\d+\.ah\d+\.gp(?:\.gz)?")
QUASILOCALMEASURES = re.compile(r"surface\d+_\d+\.vtk(?:\.gz)?")
Path_ = str | os.PathLike[str]
Simulation = tuple[list[Moment], list[ListedSlice[SliceSource]]]


def moments(
    horizons: Sequence[Any],
    geometry: ThreeGeometry | Path_ | None = None,
    surface: str | None = None,
) -> list[Moment]:
    """Horizons and their slices, from files.

    Parameters
    ----------
    horizons : sequence of paths or kuibit.simdir.SimDir
        Files with horizons (see `isoembed.relativity.series.shape_files.shapes_in_files`), folders of them,
        or folders of simulations of the Einstein Toolkit, which take kuibit; a SimDir is such a folder.
    geometry : ThreeGeometry or path, optional
        One slice for all; a file with one slice, or with those of an evolution, of any format of
        `isoembed.relativity.read_slice`; a pattern of such files as
        ``slices/gxx.{iteration}.h5``; or a folder of them or of a simulation.  Horizons and slices are
        matched by iteration if both have one, otherwise by time; a single slice without a time applies to
        all horizons.  By default horizons are from a simulation with its own slices, or have their own
        metrics.
    surface : str, optional
        Name of the series to select; by default all.

    Returns
    -------
    list of Moment
        Moments sorted by series, then by time.  A horizon without a slice has a `MissingSlice`.

    Raises
    ------
    FileError
        There is no such file or folder, no horizon in them, no slice for any of them, or no geometry for
        horizons given by coordinates.
    InvalidParameter
        Two horizons or two slices have the same moment, or a pattern is invalid.
    """
    simulated: dict[str, Simulation] = {}

    def simulation_in(folder: Any) -> Simulation:
        key = os.path.realpath(getattr(folder, "path", folder))
        if key not in simulated:
            simulated[key] = simulation(folder)
        return simulated[key]

    shapes: list[Moment] = []
    slices: list[ListedSlice[SliceSource]] = []
    for item in horizons:
        is_run = hasattr(item, "allfiles")
        if not is_run and not os.path.isdir(item):
            shapes += shapes_in_files([item])
            continue
        files = [] if is_run else shape_files_in(item)
        coordinates = any(input_ending(path) == SHAPE for path in files)
        if files and not (geometry is None and coordinates and _holds(item, GRIDS)):
            shapes += shapes_in_files(files)
            continue
        if not is_run and not _holds(item, (SHAPE,)):
            raise FileError(f"there are no files of horizons in {item}: {listing_of(item)}")
        found = simulation_in(item)
        shapes += found[0]
        slices += found[1] if geometry is None else []
    shapes = _chosen(shapes, horizons, surface)
    last_simulation = None
    if geometry is None and not slices:
        _refuse_coordinates(shapes)
        return ordered(shapes)
    if geometry is not None:
        last_simulation, slices = _slices(geometry, simulation_in)
    if last_simulation is not None:
        return ordered(replace(shape, slice=last_simulation) for shape in shapes)
    out = matched(shapes, slices)
    missing = [moment.slice.why for moment in out if isinstance(moment.slice, MissingSlice)]
    if len(missing) == len(out):
        others = f"; nor is there one for the other {len(out) - 1} horizons" if len(out) > 1 else ""
        raise FileError(missing[0] + others)
    return out


def _chosen(shapes: list[Moment], horizons: Sequence[Any], surface: str | None) -> list[Moment]:
    """Horizons of one series, or all of them."""
    if not shapes:
        names = [str(getattr(item, "path", item)) for item in horizons]
        raise FileError(f"there are no horizons in {enumerated(names) or 'no files'}")
    chosen = [shape for shape in shapes if surface is None or shape.series == surface_name(surface)]
    if not chosen:
        there = enumerated(list(dict.fromkeys(shape.series for shape in shapes)))
        raise FileError(f"there is no horizon {surface}, but {there}")
    return chosen


def _slices(
    geometry: ThreeGeometry | Path_, simulation_in: Callable[[Path_], Simulation]
) -> tuple[SliceSource | None, list[ListedSlice[SliceSource]]]:
    """A single slice for all horizons, or a list of slices."""
    if not isinstance(geometry, str | os.PathLike):
        return HeldSlice(geometry), []
    if os.path.isdir(geometry):
        slices: list[ListedSlice[SliceSource]] = [*slices_in_folder(geometry)]
        if not slices and not _holds(geometry, GRIDS):
            raise FileError(f"there are no files of slices in {geometry}: {listing_of(geometry)}")
        return None, slices or simulation_in(geometry)[1]
    if not os.path.exists(geometry):
        if is_pattern(str(geometry)):
            return None, slices_of_pattern(str(geometry))
        raise FileError(f"there is no file or folder {geometry}, nor a slice in closed form of that name")
    slices = [*slices_in_file(geometry)]
    if len(slices) == 1 and slices[0].iteration is None and slices[0].time is None:
        return slices[0].source, []
    return None, slices


def _holds(folder: Path_, endings: Sequence[str]) -> bool:
    """Whether a folder or its subfolders have files with given endings."""
    return any(input_ending(path) in endings for path in Path(folder).rglob("*"))


def _refuse_coordinates(shapes: list[Moment]) -> None:
    """Check that some horizons have a metric, from the first of each series."""
    contents = []
    for shape in {shape.series: shape for shape in reversed(shapes)}.values():
        try:
            found = shape.shape.read()
        except (FileError, InvalidMetric, InvalidParameter):
            return
        if not isinstance(found, CoordinateShape):
            return
        contents.append(found.contents)
    raise FileError(f"{contents[-1]}: name it with geometry=")


def simulation(folder: Any) -> tuple[list[Moment], list[ListedSlice[SliceSource]]]:
    """Horizons and slices of a simulation, for `isoembed.relativity.series.matching.matched`.

    Raises `FileError`: there is no such folder, it has neither horizons nor slices, none of its slices can be
    read, or kuibit is not installed.

    Parameters
    ----------
    folder : path or kuibit.simdir.SimDir
        With ``h.t*.ah*.gp`` and ``BH_diagnostics.ah*.gp`` of AHFinderDirect, or ``h.t*.ah*.gp`` and
        ``BHaHAHA_diagnostics.ah*.gp`` of BHaHAHA, or else ``surface*.vtk`` of QuasiLocalMeasures; and
        three-dimensional HDF5 files of ``ADMBase::metric`` and ``ADMBase::curv`` by Carpet, or openPMD files
        of those of ADMBaseX by CarpetX, in any subfolders.  Of duplicates, as after restarts, the last one
        counts.

    Returns
    -------
    shapes : list of Moment
        Horizons; without a time from the finder they have that of their slice.
    slices : list of ListedSlice

    Notes
    -----
    kuibit determines the files of a simulation, and is called once, in the process that lists the moments.
    The data are then read with h5py: kuibit reads all levels of a field, from the first of several restarts
    that have an iteration, and caches them.  Of 841 MB on seven levels in the files of eight
    processes its twelve fields take 4.5 s and 1.5 GB; the part of one level that a horizon needs, 76 points
    along each axis, takes 0.5 s and 0.1 GB, in a process of its own.
    """
    files = sorted(map(Path, _run_files(folder)), key=natural_order)
    shapes = _finder_shapes(files, SHAPES) or _finder_shapes(files, QUASILOCALMEASURES)
    slices = carpet_slices(files) or carpetx_slices(files)
    if not shapes and not slices:
        name = getattr(folder, "path", folder)
        raise FileError(f"there are no files of horizons or of slices in the folder {name}")
    times = {each.iteration: each.time for each in slices}
    timed = [
        shape if shape.time is not None else replace(shape, time=times.get(shape.iteration))
        for shape in shapes
    ]
    return timed, slices


def _run_files(folder: Any) -> list[str]:
    if hasattr(folder, "allfiles"):
        return list(folder.allfiles)
    if not os.path.isdir(folder):
        raise FileError(f"there is no folder {folder}")
    try:
        from kuibit.simdir import SimDir
    except ImportError:
        raise FileError(f"reading the simulation {folder} needs kuibit: pip install kuibit h5py") from None
    return list(SimDir(os.fspath(folder)).allfiles)


def _finder_shapes(files: list[Path], name: re.Pattern[str]) -> list[Moment]:
    """Horizons in files with names that match, the last one for each iteration."""
    there = shapes_in_files(path for path in files if name.fullmatch(path.name))
    return list({(shape.series, shape.iteration): shape for shape in there}.values())
