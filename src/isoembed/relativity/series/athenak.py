"""Reader for slices in binary files of AthenaK, version 1.1, variables ``adm`` or ``z4c``.

After a few lines of text and the parameters of the run come the MeshBlocks, all of one size: the indices of
the cells that are written, where the block is in the tree of blocks, its corners, and the values of all
variables one after the other, x running fastest, in single precision [1]_.

Each region of space is covered by blocks of one level only.  If a coarser level is needed, as beside a
coarser block, its values are interpolated from the finer ones, to eighth order.

References
----------
.. [1] J. M. Stone et al., "AthenaK: A Performance-Portable Version of the Athena++ AMR Framework",
   arXiv:2409.16053 (2024).
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError, reading
from isoembed.relativity.series.adm_variables import (
    AdmVariables,
    ConformalVariables,
    Variables,
    rank,
    variables_in,
)
from isoembed.relativity.series.amr_grid import PatchSlice
from isoembed.relativity.series.file_names import begins_with
from isoembed.relativity.series.grid_symmetry import AxisMap, reflections
from isoembed.relativity.series.moment import ListedFile, best_of_moments
from isoembed.relativity.series.refined_grid import Component, beyond_ghosts
from isoembed.relativity.spacetimes.cartesian_grid import STENCIL, lagrange_weights
from isoembed.relativity.spacetimes.slice_file import PAIRS

MAGIC, VERSION = "Athena binary output version=", "1.1"
RANK = re.compile(r"rank_\d+")  # folder of the files of a process
ADM = AdmVariables(tuple(f"adm_{letter}{ij}" for letter in "gK" for ij in PAIRS))


@dataclass(frozen=True)
class AthenaKSlice(PatchSlice):
    """Slice of a file of AthenaK, or of the files of all processes."""

    def data(self, closing: contextlib.ExitStack) -> _Data:
        """See `PatchSlice`."""
        return _Data(self.name, [_File.read(Path(path)) for path in self.paths])


def is_athenak(path: Path) -> bool:
    """Whether a file is of AthenaK, of any version."""
    return begins_with(path, MAGIC.encode())


def athenak_slices(paths: Iterable[Path]) -> list[ListedFile]:
    """Slices of files; any file in a folder ``rank_...`` represents those of all processes.

    Among files of the same time, those with all variables are used, ``adm`` before ``z4c``.  Raises
    `FileError`: a file cannot be read.
    """
    found: dict[Path, list[Path]] = {}
    for path in paths:
        parts = [path]
        if RANK.fullmatch(path.parent.name):
            parts = sorted(path.parent.parent.glob(f"rank_*/{path.name}"))
        found.setdefault(parts[0], parts)
    out = []
    for first, parts in found.items():
        head = _File.read(first)
        listed = ListedFile(head.cycle, head.time, AthenaKSlice(tuple(map(str, parts))))
        out.append((rank(head.names, _variable_sets(head)), listed))
    return best_of_moments(out, incomplete=2)  # neither of the two known sets


@dataclass(frozen=True)
class _File:
    """Header of a file.

    Attributes
    ----------
    path : Path
    time, cycle : float, int
    names : list of str
        Names of the variables.
    parameters : dict of str to str
        Parameters of the run, by ``block/name``.
    heads : ndarray of structures
        Headers of the blocks: ``cells``, first and last index along each axis; ``place``, the position of the
        block on its level, and the level; and ``corners``.
    start : int
        Offset of the first block in bytes.
    data : dtype
        Type of the data of a block, (variables, nz, ny, nx).
    """

    path: Path
    time: float
    cycle: int
    names: list[str]
    parameters: dict[str, str]
    heads: Any
    start: int
    data: Any

    @property
    def cells(self) -> list[int]:
        """Numbers of cells of a block along each axis, without ghost zones."""
        parameters = self.parameters
        return [int(parameters.get(f"meshblock/nx{a}", parameters[f"mesh/nx{a}"])) for a in "123"]

    @property
    def levels(self) -> Indices:
        """Levels of the blocks."""
        return np.asarray(self.heads["place"][:, 3], dtype=np.int64)

    @classmethod
    def read(cls, path: Path) -> _File:
        """Read everything except the data of the blocks."""
        with reading(path), path.open("rb") as file:
            return cls._read(path, file)

    @classmethod
    def _read(cls, path: Path, file: BinaryIO) -> _File:
        if (version := _line(file).removeprefix(MAGIC)) != VERSION:
            raise FileError(f"{path} has the version {version!r} of AthenaK, not {VERSION}")
        count = int(_after(_line(file)))
        lines = (_line(file).partition("=") for _ in range(count - 1))
        facts = {name.strip(): value.strip() for name, _, value in lines}
        number = int(_after(_line(file)))
        names = _line(file).split()[1:]
        parameters = _parameters(file.read(int(_after(_line(file)))).decode("utf-8", errors="replace"))
        if "coarsening factor" in facts:
            raise FileError(f"{path} holds averages over several cells, not values at points")
        if len(names) != number:
            raise FileError(f"{path} has the names of {len(names)} variables, not of {number}")
        for axis in "123":
            if int(parameters[f"mesh/nx{axis}"]) < 2:
                raise FileError(f"{path} is not three-dimensional: there is one cell along x{axis}")
        start, end = file.tell(), file.seek(0, 2)
        real, value = (f"<f{int(facts[f'size of {each}'])}" for each in ("location", "variable"))
        head = np.dtype([("cells", "<i4", (3, 2)), ("place", "<i4", 4), ("corners", real, (3, 2))])
        if end - start < head.itemsize:
            raise FileError(f"{path} has no MeshBlock, or is cut short")
        file.seek(start)
        cells = np.fromfile(file, head, 1)["cells"][0]
        shape = (cells[:, 1] - cells[:, 0] + 1).tolist()
        if min(shape) < 2:
            raise FileError(f"{path} is a plane or a line through the mesh (slice_x1 ... slice_x3)")
        data = np.dtype((value, (number, *shape[::-1])))
        size = head.itemsize + data.itemsize
        if (end - start) % size:
            raise FileError(f"{path} is cut short in the MeshBlock {(end - start) // size}")
        heads = []
        for at in range(start, end, size):
            file.seek(at)
            heads.append(np.fromfile(file, head, 1))
        return cls(
            path,
            float(facts["time"]),
            int(facts["cycle"]),
            names,
            parameters,
            np.concatenate(heads),
            start,
            data,
        )

    def block(self, index: int) -> Any:
        """Data of a block, (variables, nz, ny, nx)."""
        size = self.heads.itemsize
        at = self.start + index * (size + self.data.itemsize) + size
        with reading(self.path):
            return np.fromfile(self.path, self.data, 1, offset=at)[0]


@dataclass(frozen=True)
class _Block:
    """MeshBlock of a file, or its restriction to a coarser level.

    Attributes
    ----------
    file, record : int
    coarsened : int
        Number of levels by which it is coarser than in the file.
    """

    file: int
    record: int
    coarsened: int


class _Data:
    """Data of files as `PatchData`."""

    def __init__(self, name: str, files: list[_File]) -> None:
        self.name, self._files = name, files
        first = files[0]
        if strange := next((f for f in files if (f.names, f.cycle) != (first.names, first.cycle)), None):
            raise FileError(f"{strange.path} and {first.path} are not parts of the same output")
        self._variables = variables_in(first.names, _variable_sets(first), name)
        self._columns = [first.names.index(each) for each in self._variables.names]
        self._cells = first.cells
        self._check_whole()

    @cached_property
    def symmetry(self) -> tuple[AxisMap, ...]:
        parameters = self._files[0].parameters
        return reflections(
            axis
            for axis, letter in enumerate("123")
            if parameters.get(f"mesh/ix{letter}_bc") == "reflect"
            and float(parameters[f"mesh/x{letter}min"]) == 0.0
        )

    @cached_property
    def levels(self) -> list[int]:
        finest = max(int(file.levels.max()) for file in self._files)
        return [level for level in range(finest + 1) if self.components(level)]

    def components(self, level: int) -> list[Component]:
        out = []
        for number, file in enumerate(self._files):
            for record in np.flatnonzero(file.levels >= level):
                coarsened = int(file.levels[record]) - level
                if coarsened == 0 or all(n >= STENCIL and n % 2**coarsened == 0 for n in self._cells):
                    low, high = file.heads["corners"][record].astype(np.float64).T
                    shape = np.array(self._cells) >> coarsened
                    spacing = (high - low) / shape
                    block = _Block(number, int(record), coarsened)
                    out.append(Component.of(block, low + 0.5 * spacing, spacing, shape))
        return out

    def values(self, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        block: _Block = component.key
        data = self._files[block.file].block(block.record)
        ghosts = [(n - cells) // 2 for n, cells in zip(data.shape[:0:-1], self._cells, strict=True)]
        selection = part if block.coarsened == 0 else tuple(slice(0, n) for n in self._cells)
        i, j, k = beyond_ghosts(selection, ghosts)
        rows = [data[column, k, j, i].T for column in self._columns]
        fields = self._variables.adm(np.stack(rows).astype(np.float64))
        if block.coarsened == 0:
            return fields
        weights = (_coarsening(n, block.coarsened)[s] for n, s in zip(self._cells, part, strict=True))
        return np.einsum("fijk,ai,bj,ck->fabc", fields, *weights, optimize=True)

    def _check_whole(self) -> None:
        """Check by their volume that no MeshBlocks are missing."""
        parameters = self._files[0].parameters
        cells = zip("123", self._cells, strict=True)
        roots = np.prod([int(parameters[f"mesh/nx{a}"]) // n for a, n in cells])
        there = sum(float((0.125**file.levels).sum()) for file in self._files)
        if abs(there / roots - 1.0) > 1e-9:
            raise FileError(f"{self.name} has MeshBlocks for {there / roots:.6g} of the mesh only")


@lru_cache(maxsize=64)
def _coarsening(cells: int, levels: int) -> Floats:
    """Matrix from values at the centers of cells to those of cells a number of levels coarser.

    Each coarse center lies halfway between two fine ones.  The interpolation is that of `CartesianGrid`,
    one-sided at the ends of the block.
    """
    nodes, times = STENCIL, 2**levels
    at = times * np.arange(cells // times) + 0.5 * (times - 1)
    start = np.clip(np.floor(at).astype(np.int64) - (nodes // 2 - 1), 0, cells - nodes)
    matrix = np.zeros((len(at), cells))
    rows = np.arange(len(at))[:, None]
    matrix[rows, start[:, None] + np.arange(nodes)] = lagrange_weights((at - start)[:, None], nodes)[0][:, 0]
    return matrix


def _variable_sets(file: _File) -> tuple[Variables, Variables]:
    """ADM variables, and Z4c variables with the power of chi used by the run."""
    metric, curvature = (tuple(f"z4c_{letter}{ij}" for ij in PAIRS) for letter in "gA")
    trace = (("z4c_Khat", 1.0), ("z4c_Theta", 2.0))
    power = 4.0 / float(file.parameters.get("z4c/chi_psi_power", -4.0))
    return ADM, ConformalVariables("z4c_chi", metric, curvature, trace, power)


def _parameters(text: str) -> dict[str, str]:
    """Parameters of the run, by ``block/name``."""
    out, block = {}, ""
    for line in text.splitlines():
        entry = line.split("#")[0].strip()
        if entry.startswith("<"):
            block = entry.strip("<>")
        elif "=" in entry:
            name, value = map(str.strip, entry.split("=", 1))
            out[f"{block}/{name}"] = value
    return out


def _line(file: Any) -> str:
    """Next line of a binary file, as text."""
    return str(file.readline(1 << 16).decode("utf-8", errors="replace")).strip()


def _after(line: str) -> str:
    return line.split("=", 1)[1]
