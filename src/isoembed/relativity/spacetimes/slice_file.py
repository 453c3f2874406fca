"""Reader for slices on Cartesian grids, .npz or HDF5.

One slice is arrays of one shape (nx, ny, nz), [i, j, k] being the point ``origin + spacing * (i, j, k)``:
``gxx gxy gxz gyy gyz gzz`` and, unless the slice is time-symmetric, ``kxx kxy kxz kyy kyz kzz``; besides
``origin``, three numbers, and ``spacing``, three or one; and maybe ``time`` and ``iteration``, a number each.
In HDF5 they are data sets of the root group; all but the first twelve may be attributes.

T slices of an evolution have an axis of time in front: ``time`` (T,), and maybe ``iteration`` (T,), beside
arrays (T, nx, ny, nz).  ``origin`` is (3,), or (T, 3) of a grid that moves, and ``spacing`` one number, (3,),
or (T, 3).  There is no group for each time, because all times are known from one small array that way, and a
run appends to data sets that can grow.  A slice is one block of each of them: only the part of it that is
asked for is read.  Chunks should not be longer than 1 along the axis of time.  Slices with different numbers
of points go to files of their own.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError, check_ending
from isoembed.io.hdf5 import HDF5_ENDINGS, check_data_set
from isoembed.io.input_file import InputFile
from isoembed.relativity.spacetimes.cartesian_grid import OUTSIDE, CartesianGrid
from isoembed.relativity.spacetimes.checks import written

PLACE = ("origin", "spacing")
PAIRS = ("xx", "xy", "xz", "yy", "yz", "zz")
GAMMA, K = (tuple(f"{letter}{pair}" for pair in PAIRS) for letter in "gk")
INSTANT = ("time", "iteration")
SLICE_ENDINGS = (".npz", *HDF5_ENDINGS)
AROUND = 10  # margin in spacings around a box: five points for the interpolation, the rest as reserve


@dataclass(frozen=True)
class Instant:
    """Iteration and time of a slice, if they are in the file, and its index along the time axis, if any."""

    iteration: int | None
    time: float | None
    index: int | None


def read_cartesian_grid(
    path: str | os.PathLike[str],
    index: int | None = None,
    box: tuple[Floats, Floats] | None = None,
) -> CartesianGrid:
    """Read a slice from an .npz or HDF5 file, with the layout described in the module.

    Parameters
    ----------
    path : path
    index : int, optional
        Index of the slice in a file with several.
    box : pair of ndarray, each of shape (3,), optional
        Lower and upper corner of a box; only the part needed by surfaces inside is read.

    Raises
    ------
    FileError
        The file cannot be read or is incomplete, there are several slices, or the grid does not cover the
        box; the message gives the reason.
    """
    with _open_sets(path) as sets:
        _check(path, sets)
        origin, spacing = _place(path, sets, index)
        slab = _slab(path, sets["gxx"].shape[-3:], origin, spacing, box)
        first = np.array([along.start for along in slab])
        where = (*(() if index is None else (index,)), *slab)
        try:
            return CartesianGrid(
                (origin + first * spacing).tolist(),
                spacing.tolist(),
                np.stack([_part(path, name, sets[name], where) for name in GAMMA]),
                np.stack([_part(path, name, sets[name], where) for name in K]) if K[0] in sets else None,
            )
        except InvalidParameter as error:
            raise FileError(f"{path}: {error}") from None


def slice_arrays(path: str | os.PathLike[str], index: int | None) -> Iterator[tuple[str, NDArray[Any]]]:
    """Iterate over the names and arrays of a slice.

    Raises `FileError`: see `read_cartesian_grid`.
    """
    with _open_sets(path) as sets:
        _check(path, sets)
        yield from zip(PLACE, _place(path, sets, index), strict=True)
        for name in (*GAMMA, *K):
            if name in sets:
                yield name, _part(path, name, sets[name], () if index is None else (index,))


def instants(path: str | os.PathLike[str]) -> list[Instant]:
    """Times of the slices in a file, in their order; empty if it has none.

    Raises `FileError`: the file cannot be read, or its times do not match its slices.
    """
    check_ending(path, SLICE_ENDINGS)
    with InputFile(path) as file:
        if GAMMA[0] not in file.names:
            return []
        there = file.some(INSTANT)
    times, iterations = there.get("time"), there.get("iteration")
    for name, values in there.items():
        if values.dtype.kind not in "iuf" or not np.isfinite(values).all():
            raise FileError(f"{name} in {path} does not hold finite numbers")
        if values.ndim > 1:
            raise FileError(f"{name} in {path} has the shape {values.shape}, and not one axis")
        if times is not None and values.shape != times.shape:
            raise FileError(f"{name} in {path} has the shape {values.shape}, time {times.shape}")
    many = next((values.shape for values in there.values()), ())
    return [
        Instant(
            None if iterations is None else int(iterations.ravel()[k]),
            None if times is None else float(times.ravel()[k]),
            k if many else None,
        )
        for k in range(many[0] if many else 1)
    ]


@contextlib.contextmanager
def _open_sets(path: str | os.PathLike[str]) -> Iterator[Mapping[str, Any]]:
    """Arrays of a file by name; data sets of HDF5 are read lazily."""
    check_ending(path, SLICE_ENDINGS)
    wanted = (*PLACE, *INSTANT, *GAMMA, *K)
    with InputFile(path) as source:
        if source.ending == ".npz":
            yield source.some(wanted)
            return
        with source.hdf5() as file:
            attributes = {name: np.asarray(file.attrs[name]) for name in wanted if name in file.attrs}
            sets = {name: file[name] for name in wanted if getattr(file.get(name), "shape", None) is not None}
            yield attributes | sets


def _check(path: str | os.PathLike[str], sets: Mapping[str, Any]) -> None:
    """Check that a file is complete and consistent."""
    needed = (*PLACE, *GAMMA, *(K if any(name in sets for name in K) else ()))
    if missing := [name for name in needed if name not in sets]:
        raise FileError(f"{path} has no {' and no '.join(missing)}")
    for name in needed:
        if sets[name].dtype.kind not in "iuf":
            raise FileError(f"{name} in {path} does not hold real numbers")
        if name[0] in "gk" and sets[name].shape != sets["gxx"].shape:
            raise FileError(f"{name} in {path} has the shape {sets[name].shape}, gxx {sets['gxx'].shape}")


def _place(path: str | os.PathLike[str], sets: Mapping[str, Any], index: int | None) -> tuple[Floats, Floats]:
    """Origin and spacing, three numbers each, of a slice."""
    shape = sets["gxx"].shape
    if index is None and len(shape) == 4:
        raise FileError(f"{path} holds {shape[0]} slices, and isoembed.relativity.read_slice reads one")
    if len(shape) != (3 if index is None else 4):
        axes = "(nx, ny, nz)" if index is None else "(T, nx, ny, nz)"
        raise FileError(f"gxx in {path} has the shape {shape}, not {axes}")
    if index is not None and not 0 <= index < shape[0]:
        raise FileError(f"{path} holds {shape[0]} slices, and none with the index {index}")
    place = []
    for name in PLACE:
        values = np.asarray(sets[name][()], dtype=np.float64)
        if index is not None and values.shape == (shape[0], 3):
            values = values[index]
        if values.size not in ((3,) if name == "origin" else (1, 3)):
            numbers = "three numbers" if name == "origin" else "three numbers or one"
            raise FileError(f"{name} in {path} must be {numbers}, not {values.size}")
        place.append(np.broadcast_to(values.ravel(), 3))
    return place[0], place[1]


def _slab(
    path: str | os.PathLike[str],
    shape: tuple[int, ...],
    origin: Floats,
    spacing: Floats,
    box: tuple[Floats, Floats] | None,
) -> list[slice]:
    """Part of the grid needed for a box, along each axis."""
    if box is None or not (spacing > 0).all():  # the grid rejects such a spacing
        return [slice(0, n) for n in shape]
    low, high = ((corner - origin) / spacing for corner in box)
    last = np.array(shape) - 1
    if not ((low >= -OUTSIDE) & (high <= last + OUTSIDE)).all():
        raise FileError(
            f"{path} extends from {written(origin)} to {written(origin + last * spacing)}, and the "
            f"requested box from {written(box[0])} to {written(box[1])}"
        )
    start = np.maximum(np.floor(low).astype(np.int64) - AROUND, 0)
    stop = np.minimum(np.ceil(high).astype(np.int64) + AROUND, last) + 1
    return [slice(int(i), int(j)) for i, j in zip(start, stop, strict=True)]


def _part(path: str | os.PathLike[str], name: str, data: Any, where: tuple[int | slice, ...]) -> NDArray[Any]:
    """Selected part of an array."""
    if hasattr(data, "id"):
        lengths = [
            len(range(n)[along]) if isinstance(along, slice) else 1
            for along, n in zip(where, data.shape, strict=False)
        ]
        size = data.dtype.itemsize * math.prod((*lengths, *data.shape[len(where) :]))
        check_data_set(data, path, size)
    return np.asarray(data[where])
