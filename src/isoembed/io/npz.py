"""NumPy archives.  Pickled objects are never loaded: they could run code."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from isoembed.io.files import FileError, Tables


def read(path: Path) -> Tables:
    """Read the arrays of an archive by their names.

    Raises
    ------
    FileError
        The file is no archive, is damaged, or holds objects instead of numbers.
    """
    name = "the directory"
    try:
        with path.open("rb") as file:
            if file.read(4) not in (b"PK\x03\x04", b"PK\x05\x06") or not zipfile.is_zipfile(file):
                raise FileError(f"{path} is not an npz archive, or is cut short")
            file.seek(0)
            tables = {}
            with np.load(file, allow_pickle=False) as archive:
                for name in archive.files:
                    tables[name] = archive[name]
            return tables
    except FileError:
        raise
    except (
        ValueError,  # objects, a damaged header
        OSError,
        EOFError,
        MemoryError,  # a header that promises more than there is
        KeyError,
        RuntimeError,  # encrypted
        NotImplementedError,  # unknown compression
        SyntaxError,  # a header that is no Python literal
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise FileError(f"cannot read {name} of the archive {path}: {error}".splitlines()[0]) from None


def write(path: Path, tables: Tables) -> None:
    """Write named arrays."""
    with path.open("wb") as file:
        np.savez(file, **tables)
