"""Digests of files and arrays, and detection of files that change while they are read."""

import contextlib
import hashlib
import os
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, open_input

BLOCK = 1 << 20  # bytes that are hashed at once


def file_digest(path: str | os.PathLike[str]) -> str:
    """Hash of the bytes of a file, kept as long as its size and its time of change are the same.

    Raises
    ------
    FileError
        It cannot be read, or changes meanwhile.
    """
    with unchanged(path):
        return _hashed(Path(path), file_state(path))


def arrays_digest(arrays: Iterable[tuple[str, NDArray[Any]]]) -> str:
    """Hash of named arrays: their names, types, shapes and bytes."""
    sha = hashlib.sha256()
    for name, array in arrays:
        sha.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()


@contextlib.contextmanager
def unchanged(path: str | os.PathLike[str]) -> Iterator[None]:
    """Block in which a file is read, and must not be changed by others.

    Raises
    ------
    FileError
        Its size or its time of change are not the same afterward.  This is said, too, instead of what was
        wrong with a file that has changed.
    """
    before = file_state(path)
    try:
        yield
    except ValueError:  # the errors of files and of what is in them
        if file_state(path) == before:
            raise
    if file_state(path) != before:
        raise FileError(f"{path} has changed while it was read")


def file_state(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Size in bytes and time of change in nanoseconds of a file; None if there is none."""
    try:
        there = os.stat(path)
    except OSError:
        return None
    return there.st_size, there.st_mtime_ns


@lru_cache(maxsize=4096)
def _hashed(path: Path, state: tuple[int, int] | None) -> str:
    sha = hashlib.sha256()
    with open_input(path) as file:
        try:
            while block := file.read(BLOCK):
                sha.update(block)
        except OSError as error:
            raise FileError(f"cannot read {path}: {error.strerror}") from None
    return sha.hexdigest()
