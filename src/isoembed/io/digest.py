"""Digests of files and arrays, and detection of files that change during reading."""

import contextlib
import hashlib
import os
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, open_input, reading


def file_digest(path: str | os.PathLike[str]) -> str:
    """SHA-256 digest of a file, cached until its size or modification time changes.

    Raises
    ------
    FileError
        The file cannot be read, or changes during reading.
    """
    with unchanged(path):
        return _hashed(Path(path), file_state(path))


def arrays_digest(arrays: Iterable[tuple[str, NDArray[Any]]]) -> str:
    """SHA-256 digest of named arrays: names, types, shapes and bytes."""
    sha = hashlib.sha256()
    for name, array in arrays:
        sha.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()


@contextlib.contextmanager
def unchanged(path: str | os.PathLike[str]) -> Iterator[None]:
    """Context manager that checks that a file does not change while it is read.

    Raises
    ------
    FileError
        The size or modification time has changed.  This error replaces any `ValueError` raised in the
        block.
    """
    before = file_state(path)
    try:
        yield
    except ValueError:  # errors of files and of their contents
        if file_state(path) == before:
            raise
    if file_state(path) != before:
        raise FileError(f"{path} has changed while it was read")


def file_state(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Size in bytes and modification time in nanoseconds of a file; None if there is none."""
    try:
        there = os.stat(path)
    except OSError:
        return None
    return there.st_size, there.st_mtime_ns


@lru_cache(maxsize=4096)
def _hashed(path: Path, state: tuple[int, int] | None) -> str:
    sha = hashlib.sha256()
    with open_input(path) as file, reading(path):
        while block := file.read(1 << 20):
            sha.update(block)
    return sha.hexdigest()
