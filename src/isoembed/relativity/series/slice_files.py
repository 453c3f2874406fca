"""Slice files: recognition of their format, from Cartesian grids to SpECTRE; their times; reading.

A format is one `SliceFormat` in the list at the end of this module.  Files of Chombo, AMReX and AthenaK are
read by code of ours, not with yt: yt 4.4 takes 385 MB with its dependencies (Matplotlib, SymPy, unyt and
others; 121 MB are its own), has no reader for AthenaK's format, and turns patches into a data set with units
and derived fields, where the values at the points of each patch are all that is needed.
"""

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from isoembed.arrays import Floats
from isoembed.io.digest import arrays_digest, file_digest, file_state, unchanged
from isoembed.io.files import FileError, check_ending, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS
from isoembed.relativity.series.amrex import amrex_slices, is_plot_file
from isoembed.relativity.series.athenak import athenak_slices, is_athenak
from isoembed.relativity.series.carpet_files import CARPET_FILE
from isoembed.relativity.series.chombo import chombo_slices, is_chombo
from isoembed.relativity.series.file_names import entries_in, listing_of, matching_files, name_parts
from isoembed.relativity.series.moment import ListedFile, ListedSlice
from isoembed.relativity.series.source import SliceSource
from isoembed.relativity.spacetimes.slice_file import (
    SLICE_ENDINGS,
    instants,
    read_cartesian_grid,
    slice_arrays,
)
from isoembed.relativity.spacetimes.spectre_volume import (
    read_spectre_volume,
    volume_arrays,
    volume_times,
)
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class SliceFormat:
    """Format of slice files.

    Attributes
    ----------
    name : str
        Name for messages.
    holds : callable
        Whether a file or a folder is of this format.  Raises `FileError` if a damaged file does not
        permit a decision.
    slices : callable
        Takes files and folders of this format, and returns the slices in them as a list of `ListedFile`.
        Raises `FileError` where one cannot be read.
    """

    name: str
    holds: Callable[[Path], bool]
    slices: Callable[[Sequence[Path]], list[ListedFile]]


@dataclass(frozen=True)
class GridSlice:
    """Slice in a file; see `isoembed.relativity.spacetimes.slice_file`.

    Attributes
    ----------
    path : str
    index : int or None
        Index along the time axis, if there is one.
    """

    path: str
    index: int | None = None

    @property
    def name(self) -> str:
        """The path, and the index if there is one."""
        return self.path if self.index is None else f"{self.path} (index {self.index})"

    def digest(self) -> str:
        """Hash of the file, or of the arrays of the slice; see `ShapeSource`."""
        if self.index is None:
            return file_digest(self.path)
        with unchanged(self.path):
            return _digest(slice_arrays, self.path, self.index, file_state(self.path))

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """See `SliceSource`: the grid in the box and around it."""
        with unchanged(self.path):
            return read_cartesian_grid(self.path, self.index, (low, high))

    def whole(self) -> ThreeGeometry:
        """See `FileSlice`."""
        with unchanged(self.path):
            return read_cartesian_grid(self.path, self.index)


@dataclass(frozen=True)
class SliceFile:
    """Single slice in a file of any format.

    Attributes
    ----------
    path : str
    """

    path: str

    @property
    def name(self) -> str:
        """The path."""
        return self.path

    def digest(self) -> str:
        """See `ShapeSource`."""
        try:
            source = slice_in_file(self.path).source
        except FileError:  # reading will say why
            return file_digest(self.path)
        return source.digest()

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """See `SliceSource`."""
        return slice_in_file(self.path).source.read(low, high)

    def whole(self) -> ThreeGeometry:
        """See `FileSlice`."""
        return slice_in_file(self.path).source.whole()


@dataclass(frozen=True)
class SpectreSlice:
    """Slice on elements, in one or more files.

    Attributes
    ----------
    paths : tuple of str
    time : float
    """

    paths: tuple[str, ...]
    time: float

    @property
    def name(self) -> str:
        """The paths and the time."""
        return f"{', '.join(self.paths)} (t = {self.time:.9g})"

    def digest(self) -> str:
        """Hash of the data at this time; see `ShapeSource`."""
        digests = []
        for path in self.paths:
            with unchanged(path):
                digests.append(_digest(volume_arrays, path, self.time, file_state(path)))
        return " ".join(digests)

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """See `SliceSource`: the elements that may intersect the box."""
        return self._elements((low, high))

    def whole(self) -> ThreeGeometry:
        """See `FileSlice`."""
        return self._elements(None)

    def _elements(self, box: tuple[Floats, Floats] | None) -> ThreeGeometry:
        with contextlib.ExitStack() as reading:
            for path in self.paths:
                reading.enter_context(unchanged(path))
            return read_spectre_volume(self.paths, self.time, box)


def read_slice(path: str | os.PathLike[str]) -> ThreeGeometry:
    """Read a slice from a file of any format, or from the folder of a plot file of AMReX.

    Grids with refinement levels (Chombo, AMReX, AthenaK) are read lazily around surfaces, and interpolated at
    each point on the finest level that surrounds it.

    Parameters
    ----------
    path : path
        File with one slice, or folder with the files of one slice.

    Raises
    ------
    FileError
        The file cannot be read, is incomplete, or holds several slices.
    """
    return slice_in_file(path).source.whole()


def slice_in_file(path: str | os.PathLike[str]) -> ListedFile:
    """Single slice in a file or a folder.

    Raises `FileError`: it cannot be read, or holds none or several.
    """
    there = slices_in_folder(path) if os.path.isdir(path) else slices_in_file(path)
    if not there:
        raise FileError(f"there are no files of slices in {path}: {listing_of(path)}")
    if len(there) > 1:
        raise FileError(f"{path} holds {len(there)} slices, and isoembed.relativity.read_slice reads one")
    return there[0]


def slices_of_pattern(pattern: str) -> list[ListedSlice[SliceSource]]:
    """Slices in the files that match a pattern like ``slices/gxx.{iteration}.h5``.

    Raises `InvalidParameter`: it is not a pattern, see `matching_files`; `FileError`: there is no such file.
    """
    found = matching_files(pattern)
    if not found:
        raise FileError(f"no file is named like {pattern}: {listing_of(Path(pattern).parent)}")
    out: list[ListedSlice[SliceSource]] = []
    for path, iteration, time in found:
        there: Sequence[ListedFile] = ()
        with contextlib.suppress(FileError):  # reading will say why
            there = slices_in_file(path)
        if len(there) > 1:
            out += there
            continue
        one = there[0] if there else ListedFile(None, None, SliceFile(path))
        out.append(
            replace(
                one,
                iteration=one.iteration if iteration is None else iteration,
                time=one.time if time is None else time,
            )
        )
    return out


def slices_in_folder(folder: str | os.PathLike[str]) -> list[ListedFile]:
    """Slices in the files directly in a folder, by content, else by name; damaged files, too.

    Files that are parts of a slice, such as those of the processes of a run, are taken together.  Empty if
    there are damaged files only: they may be anything.  Raises `FileError`: the folder cannot be read; or it
    is a plot file of AMReX, one slice itself, and damaged.
    """
    if _format_of(Path(folder)) is not None:
        return slices_in_file(folder)
    found: dict[SliceFormat, list[Path]] = {}
    damaged = []
    for path in entries_in(folder):
        try:
            form = _format_of(path)
        except FileError:  # reading will say why
            damaged.append(path)
            continue
        if form is not None:
            found.setdefault(form, []).append(path)
    whole = [each for form in FORMATS if form in found for each in _slices(form, found[form], damaged)]
    if not whole:
        return []
    return [_named(each) for each in whole] + [
        _named(ListedFile(None, None, SliceFile(str(path)))) for path in damaged
    ]


def _slices(form: SliceFormat, paths: Sequence[Path], damaged: list[Path]) -> list[ListedFile]:
    """Slices in files of a format, read one by one if one of them is damaged."""
    try:
        return form.slices(paths)
    except FileError:
        whole = []
        for path in paths:
            try:
                form.slices([path])
                whole.append(path)
            except FileError:
                damaged.append(path)
        return form.slices(whole)


def _named(listed: ListedFile) -> ListedFile:
    """Slice with iteration and time from its file name, if it has neither."""
    if listed.iteration is not None or listed.time is not None:
        return listed
    parts = name_parts(listed.source.name)
    return replace(listed, iteration=parts.iteration, time=parts.time)


def slices_in_file(path: str | os.PathLike[str]) -> list[ListedFile]:
    """Slices in a file; a single one without a time may apply to all times.

    Raises `FileError`: it cannot be read, or holds none.
    """
    if (form := _format_of(Path(path))) is not None:
        return form.slices([Path(path)])
    if CARPET_FILE.fullmatch(Path(path).name):
        raise FileError(f"{path} is a part of a slice, as Carpet writes it: name the folder of the run")
    check_ending(path, (*SLICE_ENDINGS, ".bin"))
    raise FileError(f"{path} has no {', nor '.join(form.name for form in FORMATS)}")


def _format_of(path: Path) -> SliceFormat | None:
    """Format of a file or a folder, if it is known.  Raises `FileError`: it is damaged."""
    return next((form for form in FORMATS if form.holds(path)), None)


def _is_hdf5(path: Path) -> bool:
    return input_ending(path) in HDF5_ENDINGS and not path.is_dir()


def _holds_grids(path: Path) -> bool:
    return input_ending(path) in SLICE_ENDINGS and not path.is_dir() and bool(instants(path))


def _grid_slices(paths: Iterable[Path]) -> list[ListedFile]:
    return [
        ListedFile(one.iteration, one.time, GridSlice(str(path), one.index))
        for path in paths
        for one in instants(path)
    ]


def spectre_slices(paths: Iterable[str | os.PathLike[str]]) -> list[ListedFile]:
    """Slices at all times in the files of a run, grouped by time.

    Raises `FileError`: a file cannot be read.
    """
    found: dict[float, list[str]] = {}
    for path in paths:
        for time in volume_times(path):
            found.setdefault(time, []).append(str(path))
    return [ListedFile(None, time, SpectreSlice(tuple(found[time]), time)) for time in sorted(found)]


@lru_cache(maxsize=64)
def _digest(arrays: Callable[..., Iterator[Any]], path: str, at: float, state: Any) -> str:
    """Digest of the arrays at a time or an index of a file in a given state."""
    return arrays_digest(arrays(path, at))


FORMATS = (
    SliceFormat("gxx", _holds_grids, _grid_slices),
    SliceFormat(
        "SpatialMetric_xx on elements as SpECTRE writes them",
        lambda path: _is_hdf5(path) and bool(volume_times(path)),
        spectre_slices,
    ),
    SliceFormat(
        "levels as Chombo writes them", lambda path: _is_hdf5(path) and is_chombo(path), chombo_slices
    ),
    SliceFormat("a Header of AMReX", is_plot_file, amrex_slices),
    SliceFormat("MeshBlocks as AthenaK writes them", is_athenak, athenak_slices),
)
"""Formats of slices, in the order in which they are tried."""
