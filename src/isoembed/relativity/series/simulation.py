"""The folder of a simulation of the Einstein Toolkit: its horizons, and its slices.

kuibit knows which files belong to a simulation, and is asked once, in the process that lists the moments.
The data are then read with h5py: kuibit reads all levels of a field, from the first of several restarts that
have an iteration, and keeps what it has read.  Of 841 MB on seven levels in the files of eight processes its
twelve fields take 4.5 s and 1.5 GB; the part of one level that a horizon needs, 76 points along each axis,
takes 0.5 s and 0.1 GB, in a process of its own.
"""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from isoembed.io.files import FileError
from isoembed.relativity.series.carpet_files import carpet_slices, natural
from isoembed.relativity.series.carpetx import carpetx_slices
from isoembed.relativity.series.moment import ListedSlice, Moment
from isoembed.relativity.series.shape_files import shapes_in_files
from isoembed.relativity.series.source import SliceSource

SHAPES = re.compile(r"h\.t\d+\.ah\d+\.gp(?:\.gz)?")
QUASILOCALMEASURES = re.compile(r"surface\d+_\d+\.vtk(?:\.gz)?")


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
        of those of ADMBaseX by CarpetX, in any subfolders.  Of what is in several of them, as after restarts,
        the last one counts.

    Returns
    -------
    shapes : list of Moment
        One whose time the finder does not tell has that of its slice.
    slices : list of ListedSlice
    """
    files = sorted(map(Path, _files(folder)), key=natural)
    shapes = _shapes(files, SHAPES) or _shapes(files, QUASILOCALMEASURES)
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


def _files(folder: Any) -> list[str]:
    if hasattr(folder, "allfiles"):
        return list(folder.allfiles)
    if not os.path.isdir(folder):
        raise FileError(f"there is no folder {folder}")
    try:
        from kuibit.simdir import SimDir
    except ImportError:
        raise FileError(
            f"reading the simulation {folder} needs kuibit: pip install 'isoembed[kuibit]'"
        ) from None
    return list(SimDir(os.fspath(folder)).allfiles)


def _shapes(files: list[Path], name: re.Pattern[str]) -> list[Moment]:
    """Horizons in files of such a name, of each iteration the last."""
    there = shapes_in_files(path for path in files if name.fullmatch(path.name))
    return list({(shape.series, shape.iteration): shape for shape in there}.values())
