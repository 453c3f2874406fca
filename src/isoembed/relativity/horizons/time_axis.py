"""Reader for HDF5 files with the horizons of an evolution, with a leading time axis.

A group, or the file itself, holds ``time`` (T,), optionally ``iteration`` (T,), and the arrays of
`read_horizon` with an additional leading axis:

- ``points`` (T, V, 3), or ``x``, ``y``, ``z`` (T, V), optionally with ``faces`` (F, 3) or (T, F, 3),
  ``center`` (3,) or (T, 3), and values at the points (T, V); or
- ``q_tt``, ``q_tp``, ``q_pp`` (T, n, m), optionally with ``k``, ``p``, ``j_t``, ``j_p`` (T, n, m), on the
  angles ``theta`` (n,), ``phi`` (m,), or (T, n) and (T, m).

Arrays without a time axis are constant in time.  Several horizons have separate groups, ``/ah1``, ``/ah2``.
"""

import os
from functools import cached_property
from typing import Any

import numpy as np

from isoembed.io.files import FileError, Tables
from isoembed.io.hdf5 import HDF5_ENDINGS, check_data_set, groups_in
from isoembed.io.input_file import InputFile

RANK = {
    **dict.fromkeys(("points", "vertices", "faces"), 2),
    **dict.fromkeys(("center", "origin", "theta", "phi"), 1),
    **dict.fromkeys(("q_tt", "q_tp", "q_pp"), 2),
}
INSTANT = ("time", "iteration")
SHAPES = ("points", "vertices", "x", "q_tt", "q_pp")


class HorizonAtIndex(InputFile):
    """View of a single horizon in the file of an evolution.

    Parameters
    ----------
    path : path
    group : str
        Name of the group; "" for the file itself.
    index : int
        Index along the time axis.

    Raises
    ------
    FileError
        There is no such file.
    """

    def __init__(self, path: str | os.PathLike[str], group: str, index: int) -> None:
        super().__init__(path)
        self.group, self.index = group, index

    def __str__(self) -> str:
        return f"{self.path} ({self.group or 'horizon'}, index {self.index})"

    @cached_property
    def arrays(self) -> dict[str, Tables]:
        """Arrays of the horizon.

        Raises `FileError`: the file is damaged, or has no such group or index.
        """
        with self.hdf5() as file:
            group = file[self.group] if self.group else file
            count = _count(group)
            if not 0 <= self.index < count:
                raise FileError(f"{self.path} holds {count} horizons, and none with the index {self.index}")
            rank = 2 if "q_tt" in group or "q_pp" in group else 1
            return {
                "": {
                    name: _part(data, self, (self.index,) if _has_times(name, data, rank, count) else ())
                    for name, data in group.items()
                    if hasattr(data, "shape") and data.shape is not None and data.dtype.kind in "iuf"
                }
            }


def horizon_times(path: str | os.PathLike[str]) -> dict[str, tuple[list[float], list[int] | None]]:
    """Times and iterations of the horizons in a file with time axes, by group; empty for other files.

    Raises `FileError`: the file cannot be read, or the numbers of iterations and times differ.
    """
    found = {}
    with InputFile(path) as source:
        if source.ending not in HDF5_ENDINGS:
            return {}
        with source.hdf5() as file:
            for name, group in groups_in(file).items():
                if _count(group) and any(array in group for array in SHAPES):
                    found[name] = _times(group, f"{path} ({name})" if name else str(path))
    return found


def _count(group: Any) -> int:
    """Length of the time axis, 0 if there is none."""
    time = group.get("time")
    return len(time) if getattr(time, "ndim", None) == 1 and time.dtype.kind in "iuf" else 0


def _times(group: Any, source: str) -> tuple[list[float], list[int] | None]:
    times, iterations = np.asarray(group["time"][()], dtype=np.float64), group.get("iteration")
    bad = np.flatnonzero(~np.isfinite(times))
    if len(bad):
        raise FileError(f"{source}: time {bad[0]} is {times[bad[0]]}")
    if iterations is None:
        return times.tolist(), None
    if iterations.shape != times.shape or iterations.dtype.kind not in "iu":
        raise FileError(f"{source}: iteration is not one integer for each of the {len(times)} times")
    return times.tolist(), iterations[()].tolist()


def _has_times(name: str, data: Any, rank: int, count: int) -> bool:
    """Whether an array has a time axis, by its name and the rank of fields."""
    if name in INSTANT:
        return True
    return data.ndim > RANK.get(name, rank) and data.shape[0] == count


def _part(data: Any, file: InputFile, where: tuple[int, ...]) -> Any:
    check_data_set(data, file, data.nbytes // data.shape[0] if where else data.nbytes)
    return data[where]
