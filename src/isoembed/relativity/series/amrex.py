"""Reader for slices in AMReX plot files of GRTeclyn and CarpetX.

A plot file is a folder: its ``Header`` has the names of the variables and the spacing of each level, whose
boxes and files of data are in ``Level_N/Cell_H``; a box is a line of text and the values of all variables one
after the other, x running fastest [1]_.  CarpetX writes a plot file for each group of variables: those of the
same time are one slice.

References
----------
.. [1] W. Zhang et al., "AMReX: a framework for block-structured adaptive mesh refinement", Journal of Open
   Source Software 4 (2019), 1370; AMReX's documentation, "I/O (Plotfile, Checkpoint)".
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError, reading
from isoembed.relativity.series.adm_variables import GRCHOMBO, AdmVariables, variables_in
from isoembed.relativity.series.amr_grid import PatchSlice
from isoembed.relativity.series.file_names import begins_with
from isoembed.relativity.series.grid_symmetry import IDENTITY, AxisMap
from isoembed.relativity.series.moment import ListedFile
from isoembed.relativity.series.refined_grid import Component, beyond_ghosts

HEADER, VERSION = "Header", "HyperCLaw-V1.1"
KNOWN = (GRCHOMBO, AdmVariables())
CELL_VERSION = "1"  # version with a line of text before each box, the default of AMReX
INTEGER = re.compile(r"-?\d+")
SAME = ("low", "high", "nodal")  # attributes that agree in all plot files of a slice
REALS = {  # bits of the exponent and so on, and the order of the bytes
    ("64 11 52 0 1 12 0 1023", "8 7 6 5 4 3 2 1"): "<f8",
    ("64 11 52 0 1 12 0 1023", "1 2 3 4 5 6 7 8"): ">f8",
    ("32 8 23 0 1 9 0 127", "4 3 2 1"): "<f4",
    ("32 8 23 0 1 9 0 127", "1 2 3 4"): ">f4",
}
FAB = re.compile(rb"FAB \(\((\d+), \(([\d ]+)\)\),\((\d+), \(([\d ]+)\)\)\)(\(\(.*\)\)) (\d+)\n")


def is_plot_file(path: Path) -> bool:
    """Whether a folder is a plot file of AMReX, of any version."""
    return begins_with(path / HEADER, b"HyperCLaw")


def amrex_slices(paths: Iterable[Path]) -> list[ListedFile]:
    """Slices of plot files; files with different variables at the same time form one slice.

    Plot files without variables of a slice are omitted if others of that time have some.
    Raises `FileError`: a file cannot be read.
    """
    found: dict[tuple[int, float], list[_Header]] = {}
    for path in paths:
        header = _Header.read(path)
        found.setdefault((header.iteration, header.time), []).append(header)
    out = []
    wanted = {name for variables in KNOWN for name in variables.names}
    for (iteration, time), headers in found.items():
        groups: list[list[_Header]] = []
        for header in [each for each in headers if wanted & {*each.names}] or headers[:1]:
            apart = (g for g in groups if not any({*h.names} & {*header.names} for h in g))
            group = next(apart, None)
            if group is None:
                groups.append(group := [])
            group.append(header)
        out += [
            ListedFile(iteration, time, AMReXSlice(tuple(str(h.path) for h in group))) for group in groups
        ]
    return out


@dataclass(frozen=True)
class AMReXSlice(PatchSlice):
    """Slice of one plot file, or of several with different variables."""

    @property
    def files(self) -> Sequence[Path]:
        """See `PatchSlice`: headers and data of the plot files."""
        return [
            file
            for path in map(Path, self.paths)
            for file in (path / HEADER, *sorted(path.glob("Level_*/Cell_*")))
        ]

    def data(self, closing: contextlib.ExitStack) -> _Data:
        """See `PatchSlice`."""
        return _Data(self.name, [_Header.read(Path(path)) for path in self.paths])


@dataclass(frozen=True)
class _Header:
    """Header of a plot file.

    Attributes
    ----------
    path : Path
        Folder of the plot file.
    names : list of str
        Names of the variables.
    time, iteration : float, int
    low : ndarray, shape (3,)
        Lower corner of the domain.
    first : list of ndarray, shape (3,)
        Index of the cell at that corner, for each level.
    spacing : list of ndarray, shape (3,)
        Spacing of each level.
    cells : list of Path
        Headers of the data of each level.
    """

    path: Path
    names: list[str]
    time: float
    iteration: int
    low: Floats
    first: list[Indices]
    spacing: list[Floats]
    cells: list[Path]

    @classmethod
    def read(cls, path: Path) -> _Header:
        """Read the file ``Header`` of a plot file."""
        with reading(path / HEADER):
            lines = _lines(path / HEADER)
            version = next(lines)
            if version != VERSION:
                raise FileError(f"{path / HEADER} has the version {version!r}, not {VERSION}")
            names = [next(lines).strip() for _ in range(int(next(lines)))]
            if (dimensions := int(next(lines))) != 3:
                raise FileError(f"{path} has {dimensions} dimensions of space, not three")
            time, finest = float(next(lines)), int(next(lines))
            low = np.array(next(lines).split(), dtype=np.float64)
            next(lines)  # the upper corner
            next(lines)  # refinement ratios, which follow from the spacings
            first = [box[0] for box in _boxes(next(lines))]
            steps = next(lines).split()
            spacing = [np.array(next(lines).split(), dtype=np.float64) for _ in range(finest + 1)]
            if (coordinates := int(next(lines))) != 0:
                raise FileError(
                    f"{path} is not in Cartesian coordinates (0), but in those of the kind {coordinates}"
                )
            next(lines)  # width of boundary data
            cells = []
            for _ in range(finest + 1):
                boxes = int(next(lines).split()[1])
                for _ in range(1 + 3 * boxes):
                    next(lines)
                cells.append(path / f"{next(lines).strip()}_H")
            return cls(path, names, time, int(steps[0]), low, first, spacing, cells)


@dataclass(frozen=True)
class _Level:
    """Boxes of a level in one plot file.

    Attributes
    ----------
    low, high : ndarray of int, shape (n, 3)
        First and last index of each box, without ghost zones.
    nodal : ndarray of int, shape (3,)
        1 along axes with points at the corners of cells, 0 along axes with points at the centers.
    ghosts : ndarray of int, shape (3,)
    places : list of (Path, int)
        File and offset of each box.
    """

    low: Indices
    high: Indices
    nodal: Indices
    ghosts: Indices
    places: list[tuple[Path, int]]

    @classmethod
    def read(cls, path: Path, count: int) -> _Level:
        """Read a file ``Cell_H`` of a plot file with a given number of variables."""
        with reading(path):
            lines = _lines(path)
            if (version := next(lines).strip()) != CELL_VERSION:
                raise FileError(f"{path} has the version {version}, not {CELL_VERSION}")
            next(lines)  # distribution of the data over files, which is repeated below
            if (components := int(next(lines))) != count:
                raise FileError(f"{path} has {components} variables, but {HEADER} names {count}")
            ghosts = np.broadcast_to(np.array(INTEGER.findall(next(lines)), dtype=np.int64), 3)
            number = int(next(lines).strip("(").split()[0])
            boxes = np.array([_boxes(next(lines))[0] for _ in range(number)]).reshape(-1, 3, 3)
            next(lines)  # the closing bracket
            places = []
            for _ in range(int(next(lines))):
                _, file, start = next(lines).split()
                places.append((path.parent / file, int(start)))
            if len(places) != number or number == 0:
                raise FileError(f"{path} has {number} boxes, but the positions of {len(places)}")
            return cls(boxes[:, 0], boxes[:, 1], boxes[0, 2], ghosts, places)

    def values(self, box: int, columns: list[int], part: tuple[slice, ...]) -> Floats:
        """Values of some variables on a part of a box, (n, nx, ny, nz)."""
        path, start = self.places[box]
        nx, ny, nz = shape = (self.high[box] - self.low[box] + 1 + 2 * self.ghosts).tolist()
        i, j, k = beyond_ghosts(part, self.ghosts.tolist())
        rows = []
        with reading(path), path.open("rb") as file:
            file.seek(start)
            head = FAB.fullmatch(file.readline(4096))  # a tenth of this is usual
            kind = head and REALS.get((head[2].decode(), head[4].decode()))
            if not head or not kind:
                raise FileError(f"{path} has no box of numbers in a known format at byte {start}")
            stored = _boxes(head[5].decode())[0]
            if (stored[1] - stored[0] + 1).tolist() != shape or max(columns) >= int(head[6]):
                raise FileError(f"{path}: the box at byte {start} differs from that in Cell_H")
            first, dtype, count = file.tell(), np.dtype(kind), (k.stop - k.start) * ny * nx
            for column in columns:
                file.seek(first + dtype.itemsize * nx * ny * (column * nz + k.start))
                planes = np.fromfile(file, dtype, count)
                if len(planes) < count:
                    raise FileError(f"{path} is cut short")
                rows.append(planes.reshape(-1, ny, nx)[:, j, i].T)
        return np.stack(rows).astype(np.float64)


class _Data:
    """Data of plot files as `PatchData`."""

    symmetry: tuple[AxisMap, ...] = (IDENTITY,)

    def __init__(self, name: str, headers: list[_Header]) -> None:
        self.name = name
        self._headers = headers
        names = [each for header in headers for each in header.names]
        self._variables = variables_in(names, KNOWN, name)
        wanted = [[each for each in self._variables.names if each in header.names] for header in headers]
        self._columns = [
            [header.names.index(each) for each in some] for header, some in zip(headers, wanted, strict=True)
        ]
        order = [each for some in wanted for each in some]
        self._order = [order.index(each) for each in self._variables.names]

    @cached_property
    def levels(self) -> list[int]:
        return list(range(min(len(header.cells) for header in self._headers)))

    def components(self, level: int) -> list[Component]:
        header, first = self._headers[0], self._parts(level)[0]
        spacing = header.spacing[level]
        points = first.low - header.first[level] + 0.5 * (1 - first.nodal)
        origins, shapes = header.low + spacing * points, first.high - first.low + 1
        return [Component.of(box, origins[box], spacing, shapes[box]) for box in range(len(points))]

    def values(self, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        tables = [
            each.values(component.key, columns, part)
            for each, columns in zip(self._parts(level), self._columns, strict=True)
            if columns
        ]
        return self._variables.adm(np.concatenate(tables)[self._order])

    @cached_property
    def _levels(self) -> dict[int, list[_Level]]:
        return {}

    def _parts(self, level: int) -> list[_Level]:
        """Level in each of the plot files."""
        if level not in self._levels:
            parts = [_Level.read(header.cells[level], len(header.names)) for header in self._headers]
            for part, header in zip(parts, self._headers, strict=True):
                pairs = ([getattr(each, name) for each in (part, parts[0])] for name in SAME)
                if not all(np.array_equal(*pair) for pair in pairs):
                    first = self._headers[0].path
                    raise FileError(f"{header.path} has other boxes on level {level} than {first}")
            self._levels[level] = parts
        return self._levels[level]


def _lines(path: Path) -> Iterator[str]:
    """Lines of a text file."""
    return iter(path.read_text(encoding="utf-8").splitlines())


def _boxes(line: str) -> Indices:
    """Corners and types (n, 3, 3) of boxes in the notation of AMReX, ((0,0,0) (31,31,31) (0,0,0))."""
    return np.array(INTEGER.findall(line), dtype=np.int64).reshape(-1, 3, 3)
