"""Interface of a horizon file format: recognition and reader."""

from collections.abc import Callable
from dataclasses import dataclass

from isoembed.io.input_file import InputFile
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.spacetimes.surface_data import SurfaceData


@dataclass(frozen=True)
class HorizonFormat:
    """A format of horizon files.

    A package adds one by an entry point of the group ``isoembed.horizon_formats`` that refers to it.  It is
    asked after those of isoembed, for files that none of them recognizes.

    Attributes
    ----------
    name : str
    recognizes : callable
        Takes an `isoembed.io.InputFile` and says whether the file is of this format, by its ``ending``, its
        ``head``, or the names of its ``arrays``.
    read : callable
        Takes such a file and returns a `CoordinateShape`, or `SurfaceData` where the file has the metric.
    """

    name: str
    recognizes: Callable[[InputFile], bool]
    read: Callable[[InputFile], CoordinateShape | SurfaceData]
