"""Files of horizons: which series and moments are in them."""

import os
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS
from isoembed.io.input_file import InputFile
from isoembed.io.registry import MESH_ENDINGS
from isoembed.relativity.horizons.grid_file import ARRAY_ENDINGS
from isoembed.relativity.horizons.spectre import spectre_times
from isoembed.relativity.horizons.time_axis import horizon_times
from isoembed.relativity.series.file_names import name_parts
from isoembed.relativity.series.moment import ListedShape
from isoembed.relativity.series.shape_sources import ShapeAtIndex, ShapeFile, SpectreShape
from isoembed.relativity.spacetimes.slice_file import GAMMA

SHAPE, NUMBER = ".gp", re.compile(r"\bah\d+\b")  # of AHFinderDirect
DIAGNOSTICS = "BH_diagnostics"
INSTANT = ("time", "iteration")


def shapes_in_files(paths: Iterable[str | os.PathLike[str]]) -> list[ListedShape]:
    """Horizons that are in files, in their order; those of damaged files, too.

    Parameters
    ----------
    paths : iterable of path
        Of any format that `isoembed.relativity.read_horizon` knows: one horizon a file; all surfaces at all
        times of a SpECTRE file; all horizons of an HDF5 file with axes of time (see
        `isoembed.relativity.horizons.time_axis`).  Tables BH_diagnostics of AHFinderDirect are passed over:
        they tell the times of the shapes beside them.

    Raises
    ------
    FileError
        There is no such file.
    """
    out: list[ListedShape] = []
    for path in map(os.fspath, paths):
        if not os.path.exists(path):
            raise FileError(f"there is no file {path}")
        if not Path(path).name.startswith(DIAGNOSTICS):
            out += _listed(path)
    return out


def shape_files_in(folder: str | os.PathLike[str]) -> list[Path]:
    """Files right inside a folder that may hold horizons, by their names and, of arrays, by what is in them."""
    return [path for path in sorted(Path(folder).iterdir()) if path.is_file() and _may_be_shape(path)]


def _may_be_shape(path: Path) -> bool:
    ending = input_ending(path)
    if ending == SHAPE:
        return NUMBER.search(path.name) is not None and not path.name.startswith(DIAGNOSTICS)
    if ending not in ARRAY_ENDINGS:
        return ending in MESH_ENDINGS
    try:
        with InputFile(path) as file:
            return GAMMA[0] not in file.names and not any("::" in name for name in file.names)
    except FileError:
        return True  # reading will say why


def _listed(path: str) -> list[ListedShape]:
    ending, parts = input_ending(path), name_parts(path)
    if ending == SHAPE:
        number = NUMBER.search(Path(path).name)
        series = number[0] if number else parts.series
        time = None
        if number and parts.iteration is not None:
            time = _times(os.path.join(os.path.dirname(path), f"{DIAGNOSTICS}.{series}.gp")).get(
                parts.iteration
            )
        return [ListedShape(series, parts.iteration, time, ShapeFile(path))]
    series, iteration, time = parts.series or "horizon", parts.iteration, parts.time
    if ending in ARRAY_ENDINGS:
        try:
            if ending in HDF5_ENDINGS and (many := _many(path)):
                return many
            with InputFile(path) as file:
                there = {name: values for name, values in file.some(INSTANT).items() if values.size == 1}
            iteration = int(there["iteration"].item()) if "iteration" in there else iteration
            time = float(there["time"].item()) if "time" in there else time
        except (FileError, ValueError):
            pass  # reading will say why
    return [ListedShape(series, iteration, time, ShapeFile(path))]


def _many(path: str) -> list[ListedShape]:
    """Horizons of an HDF5 file that holds them at several times."""
    out = [
        ListedShape(surface, None, time, SpectreShape(path, surface, time))
        for surface, times in spectre_times(path).items()
        for time in times
    ]
    for group, (times, iterations) in horizon_times(path).items():
        series = group or name_parts(path).series
        out += [
            ListedShape(series, iterations and iterations[k], time, ShapeAtIndex(path, group, k))
            for k, time in enumerate(times)
        ]
    return out


@cache
def _times(path: str) -> dict[int, float]:
    """Times by iteration from the first two columns of a table of AHFinderDirect; none if there is no table."""
    times = {}
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            for line in file:
                words = line.split(maxsplit=2)[:2]
                if len(words) == 2 and words[0].isdigit():
                    try:
                        time = float(words[1])
                    except ValueError:
                        continue
                    if np.isfinite(time):
                        times[int(words[0])] = time
    except OSError:
        return {}
    return times
