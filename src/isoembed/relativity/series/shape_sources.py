"""Sources of horizons: a file, or one moment of a file with many."""

import hashlib
from dataclasses import dataclass

from isoembed.io.digest import arrays_digest, file_digest, unchanged
from isoembed.io.input_file import InputFile
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.grchombo import finder_output, read_grchombo
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.spectre import read_spectre, spectre_tables
from isoembed.relativity.horizons.time_axis import HorizonAtIndex
from isoembed.relativity.spacetimes.surface_data import SurfaceData


@dataclass(frozen=True)
class ShapeFile:
    """A file with one horizon, of any format.

    Attributes
    ----------
    path : str
    """

    path: str

    @property
    def name(self) -> str:
        """The path."""
        return self.path

    def digest(self) -> str:
        """Hash of the file: see `Source`."""
        return file_digest(self.path)

    def read(self) -> CoordinateShape | SurfaceData:
        """See `Source`."""
        with unchanged(self.path):
            return read_horizon(self.path)


@dataclass(frozen=True)
class GRChomboShape:
    """A coordinate file of GRChombo, whose origin is in another file.

    Attributes
    ----------
    path : str
    """

    path: str

    @property
    def name(self) -> str:
        """The path."""
        return self.path

    def digest(self) -> str:
        """Hash of the file and of its row in the table of the finder: see `Source`."""
        there = f"{file_digest(self.path)} {finder_output(self.path)}"
        return hashlib.sha256(there.encode()).hexdigest()

    def read(self) -> CoordinateShape | SurfaceData:
        """See `Source`."""
        with unchanged(self.path):
            return read_grchombo(self.path)


@dataclass(frozen=True)
class ShapeAtIndex:
    """A horizon in a file with an axis of time: see `isoembed.relativity.horizons.time_axis`.

    Attributes
    ----------
    path : str
    group : str
        "" is the file itself.
    index : int
    """

    path: str
    group: str
    index: int

    @property
    def name(self) -> str:
        """The path, the group and the index."""
        return f"{self.path} ({self.group or 'horizon'}, index {self.index})"

    def digest(self) -> str:
        """Hash of the arrays of this horizon: see `Source`."""
        with unchanged(self.path), self._opened() as file:
            return arrays_digest(sorted(file.arrays[""].items()))

    def read(self) -> CoordinateShape | SurfaceData:
        """See `Source`."""
        with unchanged(self.path), self._opened() as file:
            return read_horizon(file)

    def _opened(self) -> InputFile:
        return HorizonAtIndex(self.path, self.group, self.index)


@dataclass(frozen=True)
class SpectreShape:
    """A surface at a time in a file of SpECTRE.

    Attributes
    ----------
    path : str
    surface : str
    time : float
    group : str
        The name of the observation: among thousands none is looked for by its time.
    """

    path: str
    surface: str
    time: float
    group: str

    @property
    def name(self) -> str:
        """The path, the surface and the time."""
        return f"{self.path} ({self.surface} at t = {self.time:.9g})"

    def digest(self) -> str:
        """Hash of the data of this surface at this time: see `Source`."""
        with unchanged(self.path):
            return arrays_digest(sorted(spectre_tables(self.path, self.surface, self.group)[0].items()))

    def read(self) -> CoordinateShape | SurfaceData:
        """See `Source`."""
        with unchanged(self.path):
            return read_spectre(self.path, self.surface, self.group)
