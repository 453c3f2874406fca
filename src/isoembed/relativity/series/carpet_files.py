"""Index of Carpet's files in a simulation folder, across processes and restarts.

Files are named after a variable or a group, as in ``gxx.xyz.h5``, ``gxx.file_3.h5`` and
``admbase-metric.xyz.h5``, data sets as in ``ADMBASE::gxx it=1024 tl=0 rl=5 c=3``.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.io.files import FileError
from isoembed.io.hdf5 import text_of
from isoembed.relativity.series.carpet import CarpetPart, CarpetSlice, opened_unchanged
from isoembed.relativity.series.file_names import natural_order
from isoembed.relativity.series.grid_symmetry import symmetry_in
from isoembed.relativity.series.moment import ListedSlice
from isoembed.relativity.series.source import SliceSource
from isoembed.relativity.spacetimes.slice_file import GAMMA, K

CARPET_FILE = re.compile(
    r"(?P<stem>admbase-(?:metric|curv)|[gk](?:xx|xy|xz|yy|yz|zz))"
    r"(?:\.xyz)?(?:\.iter_\d+)?(?:\.file_(?P<process>\d+))?(?:\.xyz)?\.h5",
    re.IGNORECASE,
)
DATA_SET = re.compile(
    r"(?P<thorn>admbase)::(?P<field>\w+) it=(?P<iteration>\d+)"
    r"(?P<tail> tl=0(?: ml=0)?(?: m=0)?(?: rl=(?P<level>\d+))?(?: c=\d+)?)",
    re.IGNORECASE,
)
GHOSTS = re.compile(
    r"^\s*(?:carpet)?iohdf5::(?:output_ghost_points|out3d_ghosts)\s*=\s*\"?(?:no|n|false|f|0)\b",
    re.IGNORECASE | re.MULTILINE,
)
CONFORMAL = re.compile(r"^\s*admbase::metric_type\s*=\s*\"?static conformal", re.IGNORECASE | re.MULTILINE)
METADATA = "Parameters and Global Attributes"


def carpet_slices(paths: Iterable[str | Path]) -> list[ListedSlice[SliceSource]]:
    """Slices in files of Carpet; the last restart counts for an iteration in several folders.

    Raises `FileError`: there are such files, but none that can be read.

    Parameters
    ----------
    paths : iterable of path
        Files of a simulation.  Only files whose names indicate the metric or the extrinsic curvature on
        three-dimensional grids are opened.

    Returns
    -------
    list of ListedSlice
        Slices by iteration, including incomplete or damaged ones, which raise an error when read.
    """
    by_folder: dict[Path, _Folder] = {}
    for path in sorted(map(Path, paths), key=natural_order):
        if name := CARPET_FILE.fullmatch(path.name):
            by_folder.setdefault(path.parent, _Folder()).add(path, name)
    folders = [by_folder[folder] for folder in sorted(by_folder, key=natural_order)]
    flaws = [folder.flaw for folder in folders if folder.flaw]
    if flaws and not any(folder.files for folder in folders):
        raise FileError(flaws[0])
    iterations = sorted({iteration for folder in folders for iteration in folder.times})
    return [_listed(iteration, folders) for iteration in iterations]


def _listed(iteration: int, folders: list[_Folder]) -> ListedSlice[SliceSource]:
    """Slice of an iteration, with each field from the last folder that has it, complete ones preferred."""
    there = [folder for folder in folders if iteration in folder.times]
    there.sort(key=lambda folder: not folder.flaw)  # stable: the last is whole if one is
    chosen = {name: folder for folder in there for name in folder.fields(iteration)}
    parts = tuple(
        part
        for folder in there
        for part in folder.parts(iteration, [name for name, its in chosen.items() if its is folder])
    )
    flaw = next((folder.flaw for folder in chosen.values() if folder.flaw), "")
    name = f"{parts[0].path}, iteration {iteration}"
    source = CarpetSlice(name, iteration, parts, there[-1].symmetry, flaw)
    return ListedSlice(iteration, there[-1].times[iteration], source)


class _Folder:
    """Files in one folder, from the processes of one restart."""

    def __init__(self) -> None:
        self.files: list[_File] = []
        self.times: dict[int, float | None] = {}
        self._flaw = ""
        self._processes: dict[str, set[int]] = {}

    def add(self, path: Path, name: re.Match[str]) -> None:
        """Add a file."""
        if name["process"]:
            self._processes.setdefault(name["stem"], set()).add(int(name["process"]))
        try:
            file = _File.listed(path, self.times)
        except FileError as error:
            self._flaw = self._flaw or str(error)
            return
        self.files.append(file)
        self.times |= file.times
        if CONFORMAL.search(file.parameters):
            self._flaw = f"{path}: ADMBase::metric_type is static conformal: gxx ... gzz are not the metric"

    @cached_property
    def flaw(self) -> str:
        """Reason why the slices cannot be read; empty if they can."""
        wrote = max((file.processes for file in self.files), default=0)
        for stem, processes in self._processes.items():
            if (there := len(processes)) < wrote:
                folder = self.files[0].path.parent
                return self._flaw or (
                    f"{folder}: {wrote} processes wrote files, but of {stem} only those of {there} exist"
                )
        return self._flaw

    @cached_property
    def symmetry(self) -> tuple[Any, ...]:
        """Symmetry of the run."""
        return symmetry_in(next((file.parameters for file in self.files if file.parameters), ""))

    def fields(self, iteration: int) -> Iterator[str]:
        """Fields of an iteration."""
        for file in self.files:
            yield from file.sets.get(iteration, {})

    def parts(self, iteration: int, wanted: Iterable[str]) -> Iterator[CarpetPart]:
        """Parts of the files with some fields at an iteration."""
        wanted = set(wanted)
        for file in self.files:
            sets = file.sets.get(iteration, {})
            fields = sorted(wanted & sets.keys())
            for tails, alike in itertools.groupby(fields, key=lambda name: sets[name]):
                thorn, ends = tails
                yield CarpetPart(str(file.path), thorn, tuple(alike), ends, file.has_ghosts)


@dataclass(frozen=True)
class _File:
    """Contents of a file.

    Attributes
    ----------
    path : Path
    times : dict of int to float or None
        Times of iterations.
    sets : dict
        For an iteration and a field: the thorn, and the levels and ends of the names of its data sets.
    parameters : str
        Parameters of the run, one per line.
    processes : int
        Number of processes that wrote files; 0 if not in the file.
    """

    path: Path
    times: dict[int, float | None]
    sets: dict[int, dict[str, tuple[str, tuple[tuple[int, str], ...]]]]
    parameters: str
    processes: int

    @classmethod
    def listed(cls, path: Path, times_by_iteration: Mapping[int, float | None]) -> _File:
        """List the data sets of a file, and unknown times of iterations."""
        found: dict[int, dict[str, tuple[str, list[tuple[int, str]]]]] = {}
        times: dict[int, float | None] = {}
        parameters, processes = "", 0
        with opened_unchanged(str(path)) as root:
            for name in root:
                match = DATA_SET.fullmatch(name)
                if not match or match["field"] not in (*GAMMA, *K):
                    continue
                iteration = int(match["iteration"])
                sets = found.setdefault(iteration, {}).setdefault(match["field"], (match["thorn"], []))
                sets[1].append((int(match["level"] or 0), match["tail"]))
                if iteration not in times_by_iteration and iteration not in times:
                    time = root[name].attrs.get("time")
                    times[iteration] = None if time is None else float(time)
            if METADATA in root:
                metadata = root[METADATA]
                processes = int(metadata.attrs.get("nioprocs", 0))
                if "All Parameters" in metadata:
                    parameters = _text(metadata["All Parameters"][()])
        alike: dict[Any, Any] = {}  # shared by all iterations without regridding
        frozen = {
            iteration: {
                name: alike.setdefault(pair := (thorn, tuple(sorted(tails))), pair)
                for name, (thorn, tails) in fields.items()
            }
            for iteration, fields in found.items()
        }
        return cls(path, times, frozen, parameters, processes)

    @cached_property
    def has_ghosts(self) -> bool:
        """Whether ghost zones are written, as they are by default."""
        return not GHOSTS.search(self.parameters)


def _text(stored: Any) -> str:
    raw = stored if isinstance(stored, bytes) else np.asarray(stored).tobytes()
    return text_of(raw).rstrip("\0")
