"""Slices on nested refinement levels with several components (Carpet).

A level is a lattice of points, stored as components, which are boxes.  The box of a surface with the stencil
of the interpolation is filled from the components of one level and their images under the symmetry of the
run; if a level does not cover it, the next coarser one is used.

Cubes of `isoembed.relativity.series.amr_grid`, by which each point has a level of its own, would be slower
here: these files have a data set for each of the twelve fields and are read in whole rows.  For 73 points
across a horizon, 25 cubes take eight times as long as one box, and twice the memory.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.relativity.series.grid_symmetry import IDENTITY, AxisMap
from isoembed.relativity.spacetimes.cartesian_grid import STENCIL, CartesianGrid
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.slice_file import AROUND, GAMMA, K


@dataclass(frozen=True)
class Component:
    """Box of points of a refinement level.

    Attributes
    ----------
    key : object
        Identifier within its level.
    origin : tuple of three floats
        First point outside the ghost zones.
    spacing : tuple of three floats
    shape : tuple of three ints
        Points along each axis, without ghost zones: those between components belong to others, and those
        around a level are interpolated from the next coarser one.
    """

    key: Any
    origin: tuple[float, float, float]
    spacing: tuple[float, float, float]
    shape: tuple[int, int, int]

    @classmethod
    def of(cls, key: Any, origin: ArrayLike, spacing: ArrayLike, shape: ArrayLike) -> Component:
        """Component with given arrays."""
        return cls(key, *(tuple(np.asarray(each).tolist()) for each in (origin, spacing, shape)))


def beyond_ghosts(part: Sequence[slice], ghosts: Sequence[int]) -> list[slice]:
    """Part of a component in an array with ghost zones."""
    return [slice(s.start + g, s.stop + g) for s, g in zip(part, ghosts, strict=True)]


class Layout(Protocol):
    """Layout of the points of refinement levels."""

    @property
    def name(self) -> str:
        """Name for messages."""
        ...

    @property
    def symmetry(self) -> tuple[AxisMap, ...]:
        """All maps of the symmetry of the run, the identity first."""
        ...

    @property
    def levels(self) -> Sequence[int]:
        """Levels common to all fields, from coarse to fine."""
        ...

    def components(self, level: int) -> Sequence[Component]:
        """Components of a level, the same for all fields."""
        ...


class RefinedData(Layout, Protocol):
    """Fields on refinement levels, with partial reading."""

    @property
    def fields(self) -> Collection[str]:
        """Names of the available fields among gxx ... gzz and kxx ... kzz."""
        ...

    def values(self, field: str, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        """Part of a field on a component, [i, j, k] along x, y and z."""
        ...


@dataclass(frozen=True)
class Block:
    """Points of a component or its image, from `low` to below `high` on the lattice of the level."""

    component: Component
    map: AxisMap
    low: Indices
    high: Indices

    def part(self, low: Indices, high: Indices) -> tuple[slice, ...]:
        """Slices of the component that hold the points from `low` to below `high`."""
        slices = [slice(0)] * 3
        for axis, (source, sign) in enumerate(zip(self.map.source, self.map.sign, strict=True)):
            first, last = low[axis] - self.low[axis], high[axis] - self.low[axis]
            if sign < 0:
                first, last = self.component.shape[source] - last, self.component.shape[source] - first
            slices[source] = slice(int(first), int(last))
        return tuple(slices)


class Piece(NamedTuple):
    """Points of a block from `low` to below `high`."""

    block: Block
    low: Indices
    high: Indices

    @property
    def part(self) -> tuple[slice, ...]:
        """Part of the component that holds the points."""
        return self.block.part(self.low, self.high)

    def within(self, start: Indices) -> tuple[slice, ...]:
        """Place of the points in a box that begins at `start`."""
        return tuple(slice(*ends) for ends in zip(self.low - start, self.high - start, strict=True))

    def put(self, values: Floats, sign: int, table: Floats, start: Indices) -> None:
        """Write values at the points of the component, times a sign, into the table of a box."""
        np.multiply(self.block.map.turned(values), sign, out=table[self.within(start)])


def covering_grid(
    data: RefinedData, low: Floats, high: Floats, wanted: Sequence[str] = (*GAMMA, *K)
) -> CartesianGrid:
    """Part of the finest level that covers a box with the stencil of the interpolation.

    Raises `FileError`: fields are missing, no level covers the box, or components are inconsistent.

    Parameters
    ----------
    data : RefinedData
    low, high : ndarray, shape (3,)
        Corners of the box.
    wanted : sequence of str
        Names of the fields.  Without kxx ... kzz the slice is treated as time-symmetric.
    """
    if missing := [name for name in wanted if name not in data.fields]:
        needed = "gxx ... gzz" if len(wanted) == len(GAMMA) else "gxx ... gzz and kxx ... kzz"
        raise FileError(f"{data.name} has no {', '.join(missing)}: {needed} are needed")
    for number in reversed(data.levels):
        level = Level.of(data, number)
        if (box := level.around(low, high)) is not None:
            return _grid(data, number, level, box, wanted)
    coarsest = Level.of(data, data.levels[0])
    lower, upper = coarsest.box
    raise FileError(
        f"{data.name}: no refinement level covers the surface with {STENCIL // 2} points around "
        f"it, from {written(low)} to {written(high)}; the coarsest, level {data.levels[0]} with the spacing "
        f"{written(coarsest.spacing)}, has points from {written(lower)} to {written(upper)}"
    )


def _grid(
    data: RefinedData, number: int, level: Level, box: tuple[Indices, Indices], fields: Sequence[str]
) -> CartesianGrid:
    """Grid with the values read in a box of a level; missing points are NaN."""
    start, stop = box
    tables = np.full((len(fields), *(stop - start)), np.nan)
    pieces, _ = level.pieces(start, stop)
    for row, name in enumerate(fields):
        six = GAMMA if name in GAMMA else K
        for piece in reversed(pieces):
            source, sign = piece.block.map.entry(six.index(name))
            values = data.values(six[source], number, piece.block.component, piece.part)
            piece.put(values, sign, tables[row], start)
    remark = (
        f"the slice is read from refinement level {number} of {data.levels[0]} to {data.levels[-1]}, of the "
        f"spacing {written(level.spacing)}"
    )
    origin = (level.origin + level.spacing * start).tolist()
    curvature = tables[6:] if len(fields) > 6 else None
    try:
        return CartesianGrid(origin, level.spacing.tolist(), tables[:6], curvature, (remark,))
    except InvalidParameter as error:
        raise FileError(f"{data.name}, refinement level {number}: {error}") from None


@dataclass(frozen=True)
class Level:
    """Lattice of a level, and its existing boxes."""

    origin: Floats
    spacing: Floats
    blocks: list[Block]

    @classmethod
    def of(cls, data: Layout, level: int) -> Level:
        """Level of some data, with the images of its components under the symmetry of the run.

        Raises `FileError`: a component is not on the lattice of the first one.
        """
        components = data.components(level)
        origin, spacing = np.array(components[0].origin), np.array(components[0].spacing)
        blocks = []
        for image, component in itertools.product(data.symmetry, components):
            shape, h = image.permuted(component.shape), image.permuted(component.spacing)
            ends = [np.array(component.origin), component.origin + h * (np.array(component.shape) - 1)]
            ends = [image.sign * image.permuted(end) for end in ends]
            corner = (np.minimum(*ends) - origin) / spacing
            low = np.rint(corner).astype(np.int64)
            off = np.abs(np.append(corner - low, (h / spacing - 1.0) * shape))
            if not off.max() <= 1e-3:  # of a spacing
                image_of = "" if image == IDENTITY else "image, by the symmetry of the run, of the "
                raise FileError(
                    f"{data.name}, refinement level {level}: the {image_of}component that begins at "
                    f"{written(np.array(component.origin))} with the spacing "
                    f"{written(np.array(component.spacing))} is not on the lattice of the level, with a "
                    f"point at {written(origin)} and the spacing {written(spacing)}"
                )
            blocks.append(Block(component, image, low, low + shape))
        return cls(origin, spacing, blocks)

    @property
    def box(self) -> tuple[Floats, Floats]:
        """Corners of the bounding box of the level."""
        low, high = self.ends
        return self.origin + self.spacing * low, self.origin + self.spacing * (high - 1)

    @cached_property
    def _ends(self) -> tuple[Indices, Indices]:
        """Ends (n, 3) of the blocks."""
        return np.array([block.low for block in self.blocks]), np.array([block.high for block in self.blocks])

    @property
    def ends(self) -> tuple[Indices, Indices]:
        """First point, and the one after the last, along each axis of the lattice."""
        lows, highs = self._ends
        return lows.min(axis=0), highs.max(axis=0)

    def pieces(self, start: Indices, stop: Indices) -> tuple[list[Piece], Mask]:
        """Pieces of the blocks that fill a box, the first one on top, and the mask of its points in them."""
        lows, highs = self._ends
        filled = np.zeros(stop - start, dtype=bool)
        pieces = []
        for k in np.flatnonzero(((lows < stop) & (highs > start)).all(axis=1)):
            piece = Piece(self.blocks[k], np.maximum(lows[k], start), np.minimum(highs[k], stop))
            here = piece.within(start)
            if not filled[here].all():
                filled[here] = True
                pieces.append(piece)
        return pieces, filled

    def around(self, low: Floats, high: Floats) -> tuple[Indices, Indices] | None:
        """Ends of a box with its stencil and points around it; None if the stencil is incomplete."""
        reach = STENCIL // 2
        first, last = (np.floor((x - self.origin) / self.spacing).astype(np.int64) for x in (low, high))
        first, last = first - (reach - 1), last + reach + 1
        lower, upper = self.ends
        if (first < lower).any() or (last > upper).any():
            return None
        more = AROUND - reach
        start, stop = np.maximum(first - more, lower), np.minimum(last + more, upper)
        needed = tuple(slice(*ends) for ends in zip(first - start, last - start, strict=True))
        return (start, stop) if self.pieces(start, stop)[1][needed].all() else None
