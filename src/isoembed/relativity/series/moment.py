"""Time steps of an evolution: one horizon and the slice that contains it."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from isoembed.errors import InvalidParameter
from isoembed.relativity.series.source import FileSlice, ShapeSource, SliceSource

SliceT = TypeVar("SliceT", bound=SliceSource, covariant=True)
UNSAFE = re.compile(r"[^\w+.-]")  # characters not allowed in file names


@dataclass(frozen=True)
class ListedSlice(Generic[SliceT]):
    """Slice available for reading.

    Attributes
    ----------
    iteration : int or None
        Iteration of the simulation, if known.
    time : float or None
    source : SliceSource
    """

    iteration: int | None
    time: float | None
    source: SliceT


ListedFile = ListedSlice[FileSlice]
"""Slice in a file."""


def best_of_moments(found: Iterable[tuple[int, ListedFile]], incomplete: int) -> list[ListedFile]:
    """Slices with the best set of variables at each moment.

    The folder of a run has other output of the same moments: constraints, or plots of a few variables.

    Parameters
    ----------
    found : iterable of (int, ListedFile)
        Slices with the ranks of their variables (`isoembed.relativity.series.adm_variables.rank`).
    incomplete : int
        Rank of files without a complete set.  If all files of a moment are incomplete, the first is used.
    """
    moments: dict[tuple[int | None, float | None], list[tuple[int, ListedFile]]] = {}
    for one in found:
        moments.setdefault((one[1].iteration, one[1].time), []).append(one)
    out = []
    for there in moments.values():
        best = min(rank for rank, _ in there)
        listed = [one for rank, one in there if rank == best]
        out += listed[:1] if best == incomplete else listed
    return out


@dataclass(frozen=True)
class Moment:
    """Horizon of a series at a time, and its slice.

    Attributes
    ----------
    series : str
        Name of the horizon in a simulation, such as "ah1".
    time : float or None
    iteration : int or None
        Iteration of the simulation.
    shape : ShapeSource
        Source of a `CoordinateShape` or `SurfaceData`.
    slice : SliceSource or None
        None if the horizon has its own metric, or before matching.
    position : int or None
        Index in its series, used for the label if neither time nor iteration is known.

    Raises
    ------
    InvalidParameter
        The time is not a finite number.
    """

    series: str
    time: float | None
    iteration: int | None
    shape: ShapeSource
    slice: SliceSource | None = None
    position: int | None = None

    def __post_init__(self) -> None:
        if self.time is not None:
            try:
                time = float(self.time)
            except (TypeError, ValueError):
                time = math.nan
            if not math.isfinite(time):
                raise InvalidParameter(f"the time of {self.series} is {self.time!r}, not a finite number")
            object.__setattr__(self, "time", time)

    @property
    def label(self) -> str:
        """File name from the series and the iteration, time or position, in order of preference."""
        series = UNSAFE.sub("_", self.series)
        if self.iteration is not None:
            return f"{series}.t{self.iteration}"
        if self.time is not None:
            return f"{series}.T{self.time:.9g}"
        return series if self.position is None else f"{series}.{self.position}"
