"""Slices stored as patches on refinement levels (AMR), independent of the file format."""

from __future__ import annotations

import contextlib
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from isoembed.arrays import Floats
from isoembed.io.digest import file_digest, file_state, unchanged
from isoembed.relativity.series.amr_grid import AMRGrid, PatchData
from isoembed.relativity.series.moment import ListedFile


@dataclass(frozen=True)
class PatchSlice(ABC):
    """Slice in files of patches, a `SliceSource`.

    Attributes
    ----------
    paths : tuple of str
        Paths of the files, several if variables or processes have separate files.
    """

    paths: tuple[str, ...]

    @property
    def name(self) -> str:
        """First path, and the number of the others."""
        more = f" and {len(self.paths) - 1} more" if len(self.paths) > 1 else ""
        return self.paths[0] + more

    @property
    def files(self) -> Sequence[str | Path]:
        """Files of the slice."""
        return self.paths

    @abstractmethod
    def data(self, closing: contextlib.ExitStack) -> PatchData:
        """Data of the files, which stay open until `closing` is closed.

        Raises `FileError`: a file cannot be read, or lacks a variable.
        """

    @property
    def state(self) -> Any:
        """See `isoembed.relativity.series.amr_grid.PatchSource`."""
        return tuple(file_state(path) for path in self.files)

    @contextlib.contextmanager
    def opened(self) -> Iterator[PatchData]:
        """See `isoembed.relativity.series.amr_grid.PatchSource`."""
        with contextlib.ExitStack() as closing:
            for path in self.files:
                closing.enter_context(unchanged(path))
            yield self.data(closing)

    def digest(self) -> str:
        """Hash of the files.  Raises `FileError`: a file cannot be read, or changes meanwhile."""
        return hashlib.sha256(" ".join(map(file_digest, self.files)).encode()).hexdigest()

    def read(self, low: Floats, high: Floats) -> AMRGrid:
        """Slice that reads lazily the parts needed by surfaces.

        Raises `FileError`: a file cannot be read, or lacks a variable.
        """
        return self.whole()

    def whole(self) -> AMRGrid:
        """See `read`, for the whole slice.  Raises `FileError`: see `read`."""
        with self.opened():
            return AMRGrid(self, self.state)


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
