"""Result store: a folder with one file per result."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from isoembed.io.files import FileError, write_atomically
from isoembed.runs.result import Result

RESULTS, ENDING = "results", ".npz"
HIDDEN = ".isoembed-"  # prefix of the names of files being written


@dataclass(frozen=True)
class Store:
    """Results in files ``<folder>/results/<label>.<key>.npz``.

    Several processes may use one folder at a time.  If a task has several results, of other versions or
    options, the one requested last is used.  Without `labels`, results with an answer take precedence,
    because copying loses file times.

    Attributes
    ----------
    folder : Path
    labels : frozenset of str, optional
        Tasks whose results are iterated over; by default all.
    """

    folder: Path
    labels: frozenset[str] | None = None

    @classmethod
    def made(cls, folder: Path) -> Store:
        """Store in a folder, which is created if necessary.

        Raises
        ------
        FileError
            The folder cannot be created.
        """
        try:
            (folder / RESULTS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"cannot make the folder {folder / RESULTS}: {error.strerror}") from None
        return cls(folder)

    def of(self, labels: Iterable[str]) -> Store:
        """Store in the same folder with iteration restricted to the given tasks."""
        return Store(self.folder, frozenset(labels))

    def path(self, label: str, key: str) -> Path:
        """Path of a result."""
        return self.folder / RESULTS / f"{label}.{key}{ENDING}"

    def find(self, label: str, key: str) -> Result | None:
        """Stored result of a task, or None if missing or unreadable; its file becomes the latest."""
        path = self.path(label, key)
        try:
            result = Result.read(path)
            os.utime(path)
        except (FileError, OSError):  # missing, damaged, or removed meanwhile
            return None
        return result

    def keep(self, result: Result, key: str) -> None:
        """Store a result.

        Raises
        ------
        FileError
            The file cannot be written.
        """
        write_atomically({self.path(result.label, key): result.writer})

    def __iter__(self) -> Iterator[Result]:
        """One result per task, in order of labels; unreadable files are skipped."""
        found: dict[str, list[tuple[int, Path]]] = {}
        for path in sorted((self.folder / RESULTS).glob(f"*{ENDING}")):
            label = path.name.removesuffix(ENDING).rpartition(".")[0]
            try:
                modified = path.stat().st_mtime_ns
            except OSError:  # removed meanwhile
                continue
            if not path.name.startswith(HIDDEN):
                found.setdefault(label, []).append((modified, path))
        for label in sorted(found if self.labels is None else self.labels & found.keys()):
            latest = (path for _, path in sorted(found[label], reverse=True))
            results = islice(_readable(latest), None if self.labels is None else 1)
            best = max(results, key=lambda result: result.answered, default=None)  # the first of equals
            if best is not None:
                yield best


def _readable(paths: Iterable[Path]) -> Iterator[Result]:
    for path in paths:
        try:
            yield Result.read(path)
        except FileError:
            continue
