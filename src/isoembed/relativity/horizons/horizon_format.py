"""Interface of a horizon file format: recognition and reader."""

from collections.abc import Callable
from dataclasses import dataclass

from isoembed.io.input_file import InputFile
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.spacetimes.surface_data import SurfaceData


@dataclass(frozen=True)
class HorizonFormat:
    """Format of horizon files.

    A package can register a format by an entry point in the group ``isoembed.horizon_formats``.  It is tried
    after the built-in formats.

    Attributes
    ----------
    name : str
    recognizes : callable
        Takes an `isoembed.io.InputFile` and returns whether it has this format, by its ``ending``, its
        ``head``, or the names of its ``arrays``.
    read : callable
        Takes such a file and returns a `CoordinateShape`, or `SurfaceData` if the file has the metric.
    """

    name: str
    recognizes: Callable[[InputFile], bool]
    read: Callable[[InputFile], CoordinateShape | SurfaceData]
