"""Index of horizon files: their series, with iterations and times, also from the finder's tables."""

import contextlib
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS, groups_in
from isoembed.io.input_file import InputFile
from isoembed.io.registry import MESH_ENDINGS
from isoembed.relativity.horizons.grchombo import GRCHOMBO, NAME, finder_outputs, stats_path
from isoembed.relativity.horizons.grid_file import ARRAY_ENDINGS, METRIC_GRID, TEXT_ENDINGS
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.horizons.spectre import SPECTRE, spectre_times
from isoembed.relativity.horizons.time_axis import INSTANT, SHAPES, horizon_times
from isoembed.relativity.series.file_names import DECIMAL, INTEGER, files_in, name_parts
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.shape_sources import (
    GRChomboShape,
    ShapeAtIndex,
    ShapeFile,
    SpectreShape,
)
from isoembed.relativity.spacetimes.slice_file import instants
from isoembed.relativity.spacetimes.spectre_volume import volume_times

SHAPE, NUMBER = ".gp", re.compile(r"\bah\d+\b")  # files of AHFinderDirect and BHaHAHA
DIAGNOSTICS = ("BH_diagnostics", "BHaHAHA_diagnostics")
TEXT = ".dat"  # files of GRChombo and SpECTRE
NUMBERS = re.compile(rf"{INTEGER} {DECIMAL}")


def shapes_in_files(paths: Iterable[str | os.PathLike[str]]) -> list[Moment]:
    """Horizons in files, in their order, without their slices, including those of damaged files.

    Raises `FileError`: there is no such file, or no table stats_AH<number>.dat for a coordinate file of
    GRChombo; `InvalidParameter`: a file holds slices.

    Parameters
    ----------
    paths : iterable of path
        Files of any format of `isoembed.relativity.read_horizon`: one horizon per file; all surfaces at all
        times of a SpECTRE file; all horizons of an HDF5 file with time axes (see
        `isoembed.relativity.horizons.time_axis`).  Tables BH_diagnostics of AHFinderDirect and
        BHaHAHA_diagnostics of BHaHAHA are skipped; they provide the times of the shapes in their folder.
    """
    out: list[Moment] = []
    times: dict[Path, dict[int, float]] = {}  # by folder, of GRChombo by table
    for path in map(str, paths):
        if not os.path.exists(path):
            raise FileError(f"there is no file {path}")
        if input_ending(path) == TEXT and _is_of(GRCHOMBO, path):
            out.append(_of_grchombo(path, times))
        elif input_ending(path) != SHAPE:
            out += _listed(path)
        elif not Path(path).name.startswith(DIAGNOSTICS):
            number, parts = NUMBER.search(Path(path).name), name_parts(path)
            series = number[0] if number else parts.series
            folder = Path(path).parent
            if folder not in times:
                times[folder] = _times_in(folder)
            time = None if parts.iteration is None else times[folder].get(parts.iteration)
            out.append(Moment(series, time, parts.iteration, ShapeFile(path)))
    return out


def shape_files_in(folder: str | os.PathLike[str]) -> list[Path]:
    """Files in a folder, without subfolders, that may hold horizons, sorted by name."""
    return [path for path in files_in(folder) if _may_be_shape(path)]


def _may_be_shape(path: Path) -> bool:
    ending = input_ending(path)
    if ending == SHAPE:
        return NUMBER.search(path.name) is not None and not path.name.startswith(DIAGNOSTICS)
    if ending in TEXT_ENDINGS:
        return any(_is_of(format_, path) for format_ in (GRCHOMBO, SPECTRE, METRIC_GRID))
    if ending not in ARRAY_ENDINGS:
        return ending in MESH_ENDINGS
    try:
        if ending not in HDF5_ENDINGS:
            return not holds_slices(path)
        with InputFile(path) as file:
            if spectre_times(file):
                return True
            with file.hdf5() as contents:
                return any(name in group for group in groups_in(contents).values() for name in SHAPES)
    except FileError:
        return True  # reading will say why


def _is_of(format_: HorizonFormat, path: str | Path) -> bool:
    """Whether a file is readable and of a format."""
    with contextlib.suppress(FileError), InputFile(path) as file:
        return format_.recognizes(file)
    return False


def _of_grchombo(path: str, times: dict[Path, dict[int, float]]) -> Moment:
    """Coordinate file with its time; its number counts outputs of the finder and is not an iteration."""
    table, parts = stats_path(path), NAME.fullmatch(Path(path).name)
    if table is None or parts is None:
        raise FileError(f"{path} has no table stats_AH<number>.dat with its time and origin")
    if table not in times:
        times[table] = {}
        with contextlib.suppress(FileError):  # reading will say why
            times[table] = {number: row.time for number, row in finder_outputs(table).items()}
    time = times[table].get(int(parts[2]))
    return Moment(parts[1], time, int(parts[2]) if time is None else None, GRChomboShape(path))


def _listed(path: str) -> list[Moment]:
    """Horizons in one file, identified by its name if it has no further information."""
    parts = name_parts(path)
    series, iteration, time = parts.series or "horizon", parts.iteration, parts.time
    if input_ending(path) in (*ARRAY_ENDINGS, TEXT):
        with contextlib.suppress(FileError):  # reading will say why
            if many := _many(path):
                return many
    if input_ending(path) in ARRAY_ENDINGS:
        with contextlib.suppress(FileError):
            if holds_slices(path):
                raise InvalidParameter(f"{path} holds slices, not horizons: pass it as geometry=")
            with InputFile(path) as file:
                there = file.some(INSTANT)
            there = {name: values for name, values in there.items() if _is_number(values)}
            iteration = int(there["iteration"].item()) if "iteration" in there else iteration
            time = float(there["time"].item()) if "time" in there else time
    return [Moment(series, time, iteration, ShapeFile(path))]


def holds_slices(path: str | os.PathLike[str]) -> bool:
    """Whether a file of arrays holds slices.  Raises `FileError`: it cannot be read."""
    return bool(instants(path)) or (input_ending(path) in HDF5_ENDINGS and bool(volume_times(path)))


def _is_number(values: NDArray[Any]) -> bool:
    return values.size == 1 and values.dtype.kind in "iuf" and bool(np.isfinite(values).all())


def _many(path: str) -> list[Moment]:
    """Horizons of a file with several times."""
    if input_ending(path) not in (*HDF5_ENDINGS, TEXT):
        return []
    out = [
        Moment(surface, time, None, SpectreShape(path, surface, time, group))
        for surface, times in spectre_times(path).items()
        for time, group in times
    ]
    for group, (times, iterations) in ({} if out else horizon_times(path)).items():
        series = group or name_parts(path).series or "horizon"
        out += [
            Moment(series, time, iterations[k] if iterations else None, ShapeAtIndex(path, group, k))
            for k, time in enumerate(times)
        ]
    return out


def _times_in(folder: Path) -> dict[int, float]:
    """Times by iteration, from the first two columns of the finder tables in a folder of one run."""
    times: dict[int, float] = {}
    for path in sorted(path for name in DIAGNOSTICS for path in folder.glob(f"{name}*{SHAPE}")):
        with contextlib.suppress(OSError):  # a missing time is not an error of the horizon file
            lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
            rows = (line.split(maxsplit=2)[:2] for line in lines)
            times |= {int(row[0]): float(row[1]) for row in rows if NUMBERS.fullmatch(" ".join(row))}
    return times
