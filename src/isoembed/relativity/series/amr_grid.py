"""AMR slices: interpolation on the finest level at each point.

Only the parts of a level that points lie in are read, in cubes of the lattice with a margin for the
interpolation.  Where a level ends, points within four spacings of its end are interpolated on the next
coarser one.
"""

from __future__ import annotations

import contextlib
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from isoembed.arrays import Floats, Indices, Mask
from isoembed.io.digest import file_digest, file_state, unchanged
from isoembed.io.files import FileError
from isoembed.relativity.series.refined_grid import Component, Layout, Level, Piece
from isoembed.relativity.spacetimes.cartesian_grid import (
    ACROSS,
    ERROR_FACTOR,
    STENCIL,
    CartesianGrid,
    WiderStencil,
)
from isoembed.relativity.spacetimes.checks import refuse_points, written
from isoembed.relativity.spacetimes.three_geometry import (
    DerivedGeometry,
    InterpolatedGeometry,
    ThreeGeometry,
)

CUBE = 32  # points along the edge of a cube read at once: 7 MB with its margin
KEPT = 64  # number of cubes kept in memory without points of the latest evaluation
BEFORE = STENCIL // 2  # points before the one left of x: one more than the interpolation needs
EDGE = BEFORE + CUBE + BEFORE + 1  # one more after it: the error estimate needs two more

Cell = tuple[int, int, int, int]
"""Index of a level in the list of levels, and a cube of its lattice."""


class PatchData(Layout, Protocol):
    """ADM variables on refinement levels, with partial reading."""

    def values(self, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        """Twelve fields gxx ... gzz and kxx ... kzz, (12, nx, ny, nz), on a part of a component."""
        ...


@dataclass(frozen=True)
class PatchSlice(ABC):
    """Slice in files of patches, a `SliceSource`.

    Attributes
    ----------
    paths : tuple of str
        Paths of the files, several if variables or processes have separate files.
    """

    paths: tuple[str, ...]

    @property
    def name(self) -> str:
        """First path, and the number of the others."""
        more = f" and {len(self.paths) - 1} more" if len(self.paths) > 1 else ""
        return self.paths[0] + more

    @property
    def files(self) -> Sequence[str | Path]:
        """Files of the slice."""
        return self.paths

    @abstractmethod
    def data(self, closing: contextlib.ExitStack) -> PatchData:
        """Data of the files, which stay open until `closing` is closed.

        Raises `FileError`: a file cannot be read, or lacks a variable.
        """

    @property
    def state(self) -> Any:
        """State of the files, which changes if they are modified."""
        return tuple(file_state(path) for path in self.files)

    @contextlib.contextmanager
    def opened(self) -> Iterator[PatchData]:
        """Context manager that opens the files, and checks that they are not modified meanwhile."""
        with contextlib.ExitStack() as closing:
            for path in self.files:
                closing.enter_context(unchanged(path))
            yield self.data(closing)

    def digest(self) -> str:
        """Hash of the files.  Raises `FileError`: a file cannot be read, or changes meanwhile."""
        return hashlib.sha256(" ".join(map(file_digest, self.files)).encode()).hexdigest()

    def read(self, low: Floats, high: Floats) -> AMRGrid:
        """Slice that reads lazily the parts needed by surfaces.

        Raises `FileError`: a file cannot be read, or lacks a variable.
        """
        return self.whole()

    def whole(self) -> AMRGrid:
        """See `read`, for the whole slice.  Raises `FileError`: see `read`."""
        with self.opened():
            return AMRGrid(self, self.state)


@dataclass(frozen=True, eq=False)
class AMRGrid(InterpolatedGeometry):
    """Slice on refinement levels.

    Evaluation of a field raises `InvalidParameter`: no level contains a point with its interpolation stencil;
    `FileError`: the files cannot be read, or have been modified.

    Attributes
    ----------
    source : PatchSlice
        Source of the data, read when needed.
    state : object
        State of the files; nothing more is read after they have been modified.
    """

    source: PatchSlice
    state: Any

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`: False, as there always is a K_ij."""
        return False

    @property
    def notes(self) -> tuple[str, ...]:
        """See `ThreeGeometry`."""
        first, last = self._levels[0], self._levels[-1]
        if first is last:
            return ()
        return (
            f"the slice has {len(self._levels)} refinement levels, with spacings from {first.spacing[0]:.6g} "
            f"to {last.spacing[0]:.6g}: at each point the finest one around it is used",
        )

    @property
    def box(self) -> tuple[Floats, Floats]:
        """See `ThreeGeometry`: the box in which the coarsest level can be interpolated."""
        level = self._levels[0]
        low, high = level.ends
        room = BEFORE - 1
        return level.origin + level.spacing * (low + room), level.origin + level.spacing * (high - 1 - room)

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`: as in `CartesianGrid`."""
        return np.asarray(ERROR_FACTOR * (quantity(_Wider(self)) - quantity(self)))

    def least_diameter(self, x: Floats) -> float:
        """See `ThreeGeometry`: 20 spacings of the coarsest level interpolated there."""
        coarsest = min(number for (number, *_), _ in self._located(x))
        return ACROSS * float(self._levels[coarsest].spacing.max())

    def _field(self, name: str, x: Floats, more: bool = False) -> Floats:
        out = np.empty((len(x), *[3] * (3 if name == "gradient" else 2)))
        located = self._located(np.asarray(x, dtype=np.float64))
        self._read([cell for cell, _ in located])
        for cell, points in located:
            cube = self._cubes[cell]
            out[points] = getattr(WiderStencil(cube) if more else cube, name)(x[points])
        return out

    def _located(self, x: Floats) -> list[tuple[Cell, Indices]]:
        """Cubes, and the indices of the points interpolated in each."""
        key = x.tobytes()
        if key not in self._latest:
            if len(self._latest) == 4:  # size of the cache
                del self._latest[next(iter(self._latest))]
            self._latest[key] = self._searched(x)
        return self._latest[key]

    def _searched(self, x: Floats) -> list[tuple[Cell, Indices]]:
        left = np.flatnonzero(np.isfinite(x).all(axis=1))
        out: list[tuple[Cell, Indices]] = []
        for number in reversed(range(len(self._levels))):
            level = self._levels[number]
            low, high = level.ends
            points = np.floor((x[left] - level.origin) / level.spacing).astype(np.int64)
            inside = np.flatnonzero(((points >= low) & (points < high)).all(axis=1))
            cubes, which = np.unique(points[inside] // CUBE, axis=0, return_inverse=True)
            found = []
            for k, cube in enumerate(cubes):
                here = inside[which.ravel() == k]
                cell = (number, *cube.tolist())
                whole = self._cover(cell)[1][tuple((points[here] - cube * CUBE).T)]
                if whole.any():
                    found.append(here[whole])
                    out.append((cell, left[here[whole]]))
            left = np.delete(left, np.concatenate(found)) if found else left
        missing = np.ones(len(x), dtype=bool)
        for _, here in out:
            missing[here] = False
        lower, upper = self.box
        refuse_points(
            missing,
            x,
            f"is in no refinement level of {self.source.name} with {STENCIL // 2} points on each "
            f"side; the coarsest can be interpolated from {written(lower)} to {written(upper)}",
        )
        return out

    def _cover(self, cell: Cell) -> tuple[list[Piece], Mask]:
        """Pieces that fill a cube, and the mask of its points with a complete interpolation stencil."""
        if cell not in self._covers:
            number, *cube = cell
            start = np.array(cube) * CUBE - BEFORE
            pieces, whole = self._levels[number].pieces(start, start + EDGE)
            for axis in range(3):
                whole = np.all(sliding_window_view(whole, STENCIL, axis=axis), axis=-1)
            inner = slice(1, 1 + CUBE)
            self._covers[cell] = pieces, whole[inner, inner, inner]
        return self._covers[cell]

    def _read(self, cells: list[Cell]) -> None:
        """Read cubes that are not in memory, and drop others if there are too many."""
        wanted = dict.fromkeys(cells)
        new = [cell for cell in wanted if cell not in self._cubes]
        if not new:
            return
        others = [cell for cell in self._cubes if cell not in wanted]
        for cell in others[: max(0, len(self._cubes) + len(new) - max(KEPT, len(wanted)))]:
            del self._cubes[cell]
        with self._opened() as data:
            for cell in new:
                number, *cube = cell
                level = self._levels[number]
                start = np.array(cube) * CUBE - BEFORE
                tables = np.full((12, EDGE, EDGE, EDGE), np.nan)
                for piece in reversed(self._cover(cell)[0]):
                    values = data.values(data.levels[number], piece.block.component, piece.part)
                    for row in range(12):
                        source, sign = piece.block.map.entry(row % 6)
                        piece.put(values[row - row % 6 + source], sign, tables[row], start)
                origin = (level.origin + level.spacing * start).tolist()
                self._cubes[cell] = CartesianGrid(origin, level.spacing.tolist(), tables[:6], tables[6:])

    @contextlib.contextmanager
    def _opened(self) -> Any:
        if self.source.state != self.state:
            raise FileError(f"{self.source.name} has changed since it was opened")
        with self.source.opened() as data:
            yield data

    @cached_property
    def _levels(self) -> list[Level]:
        with self._opened() as data:
            return [Level.of(data, level) for level in data.levels]

    @cached_property
    def _covers(self) -> dict[Cell, tuple[list[Piece], Mask]]:
        return {}

    @cached_property
    def _cubes(self) -> dict[Cell, CartesianGrid]:
        return {}

    @cached_property
    def _latest(self) -> dict[bytes, list[tuple[Cell, Indices]]]:
        return {}

    def __getstate__(self) -> dict[str, Any]:
        return {"source": self.source, "state": self.state}


@dataclass(frozen=True, eq=False)
class _Wider(InterpolatedGeometry, DerivedGeometry):
    """Slice interpolated with two more points along each axis, or two fewer where these are missing."""

    grid: AMRGrid

    def _field(self, name: str, x: Floats) -> Floats:
        return self.grid._field(name, x, more=True)
