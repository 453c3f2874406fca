"""Sources of horizons: a file, or one moment of a file with several."""

import hashlib
from dataclasses import dataclass

from isoembed.io.digest import arrays_digest, file_digest, unchanged
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.grchombo import finder_output, read_grchombo
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.spectre import read_spectre, spectre_tables
from isoembed.relativity.horizons.time_axis import HorizonAtIndex
from isoembed.relativity.spacetimes.surface_data import SurfaceData


@dataclass(frozen=True)
class ShapeFile:
    """File of any format with one horizon.

    Attributes
    ----------
    path : str
    """

    path: str

    @property
    def name(self) -> str:
        """Path, and the part of the file."""
        return self.path

    def digest(self) -> str:
        """Hash of the content read; see `ShapeSource`."""
        return file_digest(self.path)

    def read(self) -> CoordinateShape | SurfaceData:
        """See `ShapeSource`."""
        with unchanged(self.path):
            return self._read()

    def _read(self) -> CoordinateShape | SurfaceData:
        return read_horizon(self.path)


@dataclass(frozen=True)
class GRChomboShape(ShapeFile):
    """Coordinate file of GRChombo, with the origin in another file."""

    def digest(self) -> str:
        """Hash of the file and of its row in the table of the finder; see `ShapeSource`."""
        there = f"{file_digest(self.path)} {finder_output(self.path)}"
        return hashlib.sha256(there.encode()).hexdigest()

    def _read(self) -> CoordinateShape | SurfaceData:
        return read_grchombo(self.path)


@dataclass(frozen=True)
class ShapeAtIndex(ShapeFile):
    """Horizon in a file with a time axis; see `isoembed.relativity.horizons.time_axis`.

    Attributes
    ----------
    group : str
        Name of the group; "" for the file itself.
    index : int
    """

    group: str
    index: int

    @property
    def name(self) -> str:
        """See `ShapeFile`."""
        return f"{self.path} ({self.group or 'horizon'}, index {self.index})"

    def digest(self) -> str:
        """See `ShapeFile`."""
        with unchanged(self.path), HorizonAtIndex(self.path, self.group, self.index) as file:
            return arrays_digest(sorted(file.arrays[""].items()))

    def _read(self) -> CoordinateShape | SurfaceData:
        with HorizonAtIndex(self.path, self.group, self.index) as file:
            return read_horizon(file)


@dataclass(frozen=True)
class SpectreShape(ShapeFile):
    """Surface at a time in a file of SpECTRE.

    Attributes
    ----------
    surface : str
    time : float
    group : str
        Name of the observation, which avoids a search by time.
    """

    surface: str
    time: float
    group: str

    @property
    def name(self) -> str:
        """See `ShapeFile`."""
        return f"{self.path} ({self.surface} at t = {self.time:.9g})"

    def digest(self) -> str:
        """See `ShapeFile`."""
        with unchanged(self.path):
            return arrays_digest(sorted(spectre_tables(self.path, self.surface, self.group)[0].items()))

    def _read(self) -> CoordinateShape | SurfaceData:
        return read_spectre(self.path, self.surface, self.group)
