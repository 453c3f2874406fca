"""Slices in volume files of SpECTRE: which times are in them, and what reads each."""

import contextlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from isoembed.arrays import Floats
from isoembed.io.digest import arrays_digest, file_state, unchanged
from isoembed.relativity.series.moment import ListedFile
from isoembed.relativity.spacetimes.spectre_volume import (
    read_spectre_volume,
    volume_arrays,
    volume_times,
)
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class SpectreSlice:
    """A slice on elements, in one or more files.

    Attributes
    ----------
    paths : tuple of str
    time : float
    """

    paths: tuple[str, ...]
    time: float

    @property
    def name(self) -> str:
        """The paths and the time."""
        return f"{', '.join(self.paths)} (t = {self.time:.9g})"

    def digest(self) -> str:
        """Hash of the data of this time: see `Source`."""
        digests = []
        for path in self.paths:
            with unchanged(path):
                digests.append(_digest(path, self.time, file_state(path)))
        return " ".join(digests)

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """See `SliceSource`: the elements that may be in the box."""
        return self._elements((low, high))

    def whole(self) -> ThreeGeometry:
        """See `FileSlice`."""
        return self._elements(None)

    def _elements(self, box: tuple[Floats, Floats] | None) -> ThreeGeometry:
        with contextlib.ExitStack() as reading:
            for path in self.paths:
                reading.enter_context(unchanged(path))
            return read_spectre_volume(self.paths, self.time, box)


def spectre_slices(paths: Iterable[str | os.PathLike[str]]) -> list[ListedFile]:
    """Slices at all times of the files of one run, those of a time together.

    Raises
    ------
    FileError
        A file cannot be read.
    """
    found: dict[float, list[str]] = {}
    for path in paths:
        for time in volume_times(path):
            found.setdefault(time, []).append(str(path))
    return [ListedFile(None, time, SpectreSlice(tuple(found[time]), time)) for time in sorted(found)]


@lru_cache(maxsize=64)
def _digest(path: str, time: float, state: tuple[int, int] | None) -> str:
    return arrays_digest(volume_arrays(path, time))
