"""Files of slices: which moments are in them, and what reads each."""

import contextlib
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from isoembed.arrays import Floats
from isoembed.io.digest import arrays_digest, file_digest, file_state, unchanged
from isoembed.io.files import FileError, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS
from isoembed.relativity.series.carpet_files import CARPET_FILE
from isoembed.relativity.series.file_names import files_in, listing_of, matching_files, name_parts
from isoembed.relativity.series.moment import ListedSlice
from isoembed.relativity.series.spectre_slices import spectre_slices
from isoembed.relativity.spacetimes.slice_file import (
    SLICE_ENDINGS,
    Instant,
    instants,
    read_cartesian_grid,
    slice_arrays,
)
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class GridSlice:
    """A slice in a file: see `isoembed.relativity.spacetimes.slice_file`.

    Attributes
    ----------
    path : str
    index : int or None
        Along the axis of time, if there is one.
    """

    path: str
    index: int | None = None

    @property
    def name(self) -> str:
        """The path, and the index if there is one."""
        return self.path if self.index is None else f"{self.path} (index {self.index})"

    def digest(self) -> str:
        """Hash of the file, or of the arrays of the one slice in it: see `Source`."""
        if self.index is None:
            return file_digest(self.path)
        with unchanged(self.path):
            return _slice_digest(self.path, self.index, file_state(self.path))

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """See `SliceSource`: the grid in the box and around it."""
        with unchanged(self.path):
            return read_cartesian_grid(self.path, self.index, (low, high))


def slices_of_pattern(pattern: str) -> list[ListedSlice]:
    """Slices in the files whose names a pattern like ``slices/gxx.{iteration}.h5`` makes.

    Raises
    ------
    InvalidParameter
        It is no pattern: see `isoembed.relativity.series.file_names.matching_files`.
    FileError
        There is no such file.
    """
    found = matching_files(pattern)
    if not found:
        raise FileError(f"no file is named like {pattern}: {listing_of(Path(pattern).parent)}")
    out = []
    for path, iteration, time in found:
        there = []
        with contextlib.suppress(FileError):  # reading will say why
            there = instants(path)
        named = Instant(iteration, time, None)
        out += [_listed(path, named if one.index is None else one, one) for one in there or [named]]
    return out


def slices_in_folder(folder: str | os.PathLike[str]) -> list[ListedSlice]:
    """Slices in the files right inside a folder, by what is in them, else by name; damaged files, too.

    Volume files of SpECTRE are taken as those of one run.  Empty if there are damaged files only: they may be
    anything.
    """
    whole, damaged, others = [], [], []
    for path in files_in(folder):
        if input_ending(path) not in SLICE_ENDINGS:
            continue
        parts = name_parts(path)
        named = Instant(parts.iteration, parts.time, None)
        try:
            there = instants(path)
        except FileError:  # reading will say why
            damaged.append(_listed(str(path), named, named))
            continue
        if not there and input_ending(path) in HDF5_ENDINGS:
            others.append(path)
        for one in there:
            says = one.index is not None or one.iteration is not None or one.time is not None
            whole.append(_listed(str(path), one if says else named, one))
    whole += spectre_slices(others)
    return whole and whole + damaged


def slices_in_file(path: str | os.PathLike[str]) -> list[ListedSlice]:
    """Slices in a file; one that does not say when it is may be that of all times.

    Raises
    ------
    FileError
        It cannot be read, or holds none.
    """
    there = [_listed(str(path), one, one) for one in instants(path)]
    if not there and input_ending(path) in HDF5_ENDINGS:
        there = spectre_slices([path])
    if not there and CARPET_FILE.fullmatch(Path(path).name):
        raise FileError(f"{path} is a part of a slice, as Carpet writes it: name the folder of the run")
    if not there:
        raise FileError(f"{path} has no gxx, nor SpatialMetric_xx on elements as SpECTRE writes them")
    return there


def _listed(path: str, first: Instant, second: Instant) -> ListedSlice:
    """A slice in a file by what is known of it, the second where the first does not say."""
    return ListedSlice(
        second.iteration if first.iteration is None else first.iteration,
        second.time if first.time is None else first.time,
        GridSlice(path, second.index),
    )


@lru_cache(maxsize=64)
def _slice_digest(path: str, index: int, state: tuple[int, int] | None) -> str:
    return arrays_digest(slice_arrays(path, index))
