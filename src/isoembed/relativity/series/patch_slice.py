"""Sources of slices in files of patches on refinement levels, whatever the format."""

from __future__ import annotations

import contextlib
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from isoembed.arrays import Floats
from isoembed.io.digest import file_digest, file_state, unchanged
from isoembed.relativity.series.leveled_grid import LeveledGrid, PatchData


class PatchSlice(ABC):
    """A slice in files of patches: a `SliceSource`.  Subclasses are frozen dataclasses of paths."""

    @property
    @abstractmethod
    def name(self) -> str:
        """For messages and reports."""

    @property
    @abstractmethod
    def files(self) -> Sequence[str | Path]:
        """What the slice is read from."""

    @abstractmethod
    def data(self, closing: contextlib.ExitStack) -> PatchData:
        """The data of the files, which stay open as long as `closing` does.

        Raises
        ------
        FileError
            They cannot be read, or lack a variable.
        """

    @property
    def state(self) -> Any:
        """See `isoembed.relativity.series.leveled_grid.PatchSource`."""
        return tuple(file_state(path) for path in self.files)

    @contextlib.contextmanager
    def opened(self) -> Iterator[PatchData]:
        """See `isoembed.relativity.series.leveled_grid.PatchSource`."""
        with contextlib.ExitStack() as closing:
            for path in self.files:
                closing.enter_context(unchanged(path))
            yield self.data(closing)

    def digest(self) -> str:
        """Hash of the files.

        Raises
        ------
        FileError
            A file cannot be read, or changes meanwhile.
        """
        return hashlib.sha256(" ".join(map(file_digest, self.files)).encode()).hexdigest()

    def read(self, low: Floats, high: Floats) -> LeveledGrid:
        """The slice, of which no more is read than what surfaces need when they ask for it.

        Raises
        ------
        FileError
            A file cannot be read, or lacks a variable.
        """
        return self.whole()

    def whole(self) -> LeveledGrid:
        """See `read`: everywhere.

        Raises
        ------
        FileError
            As of `read`.
        """
        with self.opened():
            return LeveledGrid(self, self.state)
