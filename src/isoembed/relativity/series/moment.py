"""Time steps of an evolution: one horizon and the slice that contains it."""

import math
import re
from dataclasses import dataclass
from typing import Generic, TypeVar

from isoembed.errors import InvalidParameter
from isoembed.relativity.series.source import FileSlice, ShapeSource, SliceSource

SliceT = TypeVar("SliceT", bound=SliceSource, covariant=True)
UNSAFE = re.compile(r"[^\w+.-]")  # in the name of a file


@dataclass(frozen=True)
class ListedSlice(Generic[SliceT]):
    """A slice that is there to be read.

    Attributes
    ----------
    iteration : int or None
        Of the simulation, where it is known.
    time : float or None
    source : SliceSource
    """

    iteration: int | None
    time: float | None
    source: SliceT


ListedFile = ListedSlice[FileSlice]
"""A slice that is in a file."""


@dataclass(frozen=True)
class Moment:
    """A horizon of a series at a time, and the slice that it is in.

    Attributes
    ----------
    series : str
        Which of the horizons of a simulation: "ah1".
    time : float or None
    iteration : int or None
        Of the simulation.
    shape : Source
        Reads a `CoordinateShape`, or `SurfaceData`.
    slice : SliceSource or None
        None where the horizon has a metric of its own, or its slice is still to be matched.
    position : int or None
        Which of its series it is, where neither time nor iteration tell.

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
        """Name for a file: of the series, and of the iteration, else the time, else the position."""
        series = UNSAFE.sub("_", self.series)
        if self.iteration is not None:
            return f"{series}.t{self.iteration}"
        if self.time is not None:
            return f"{series}.T{self.time:.9g}"
        return series if self.position is None else f"{series}.{self.position}"
