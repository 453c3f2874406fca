"""Input files, opened once."""

from __future__ import annotations

import codecs
import contextlib
import gzip
import io
import os
import re
import tokenize
import zipfile
import zlib
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io.expansion import check_expansion, largest_expansion
from isoembed.io.files import FileError, Tables, first_line, input_ending, open_input
from isoembed.io.hdf5 import HDF5_ENDINGS, array_of, enumerated, groups_in, listing, numbers_in

GZIP = b"\x1f\x8b"
NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f-\x9f]")  # control characters, of Latin-1 too


class InputFile(os.PathLike[str]):
    """A file that is opened once, and decompressed if it is gzipped; a context manager, and a path.

    Parameters
    ----------
    path : path

    Attributes
    ----------
    path : Path
    ending : str
        The ending of its name in lower case, with its dot; that before ``.gz`` where there is one.
    head : str
        Its first 65,536 bytes as text, to recognize formats by.

    Raises
    ------
    FileError
        There is no such file, it is a folder, or it cannot be read or decompressed.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.ending = input_ending(self.path)
        with contextlib.ExitStack() as closing:
            self._stream: BinaryIO = closing.enter_context(open_input(self.path))
            first = self._stream.peek()  # type: ignore[attr-defined]
            if first.startswith(GZIP):
                self._stream = io.BytesIO(_decompressed(self._stream, self.path))
                first = self._stream.getbuffer()[: io.DEFAULT_BUFFER_SIZE]
            self.head = bytes(first).decode("utf-8", errors="replace")
            self._closing = closing.pop_all()

    def __fspath__(self) -> str:
        return str(self.path)

    __str__ = __fspath__

    def __enter__(self) -> InputFile:
        return self

    def __exit__(self, *exception: object) -> None:
        self._closing.close()

    @cached_property
    def data(self) -> bytes:
        """Bytes of the file."""
        return self._stream.read()

    @cached_property
    def text(self) -> str:
        """Text of the file.

        Raises
        ------
        FileError
            It has bytes of no text.  Text is in UTF-8, UTF-16 with a byte order mark, or Latin-1.
        """
        utf_16 = self.data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            return self.data.decode("utf-16" if utf_16 else "utf-8")
        except UnicodeDecodeError:
            if utf_16 or NO_TEXT.search(self.data):
                raise FileError(f"{self} is not a text file") from None
            return self.data.decode("latin-1")

    @cached_property
    def arrays(self) -> dict[str, Tables]:
        """Arrays of a ``.npz`` archive by their names, or those of numbers in an HDF5 file, by their groups.

        The group at the top, the only one of an archive, is ``""``.

        Raises
        ------
        FileError
            It is damaged, or something else.
        """
        if self.ending not in HDF5_ENDINGS:
            return {"": _archive(self._stream, str(self))[1]}
        with self.hdf5() as file:
            return {name: numbers_in(group, self) for name, group in groups_in(file).items()}

    @property
    def names(self) -> list[str]:
        """Names of the arrays of a ``.npz`` archive, or of all that is at the top of an HDF5 file.

        Raises
        ------
        FileError
            As of `arrays`.
        """
        if self.ending not in HDF5_ENDINGS:
            return _archive(self._stream, str(self), ())[0]
        with self.hdf5() as file:
            return [*file, *file.attrs]

    def some(self, wanted: Collection[str]) -> Tables:
        """Arrays of these names that the file has; no others are read.

        Parameters
        ----------
        wanted : collection of str
            Names of arrays of a ``.npz`` archive, or of data sets or attributes at the top of an HDF5 file.

        Raises
        ------
        FileError
            As of `arrays`.
        """
        if self.ending not in HDF5_ENDINGS:
            return _archive(self._stream, str(self), wanted)[1]
        with self.hdf5() as file:
            attributes = {name: np.asarray(file.attrs[name]) for name in wanted if name in file.attrs}
            sets = {name: file[name] for name in wanted if hasattr(file.get(name), "shape")}
            return attributes | {name: array_of(data, self) for name, data in sets.items()}

    @property
    def contents(self) -> str:
        """List of the contents of a ``.npz`` archive or an HDF5 file, for error messages."""
        if self.ending not in HDF5_ENDINGS:
            return enumerated(self.arrays[""]) or "nothing"
        with self.hdf5() as file:
            return listing(file)

    @contextlib.contextmanager
    def hdf5(self) -> Iterator[Any]:
        """Open an HDF5 file with h5py; in the block what h5py raises of damaged data is a `FileError`.

        Raises
        ------
        FileError
            It is damaged or no HDF5 file, or h5py is not installed.
        """
        try:
            import h5py
        except ImportError:
            raise FileError(f"reading {self} needs h5py: pip install h5py") from None
        try:
            if not hasattr(self, "_hdf5"):
                self._hdf5 = self._closing.enter_context(h5py.File(self._stream, "r"))
            yield self._hdf5
        except (FileError, InvalidMetric, InvalidParameter):
            raise
        except (OSError, KeyError, RuntimeError, TypeError, ValueError) as error:  # h5py's: damaged
            why = first_line(" ".join(str(error).split()).strip("'\""))
            # Its frames hold h5py's driver of open files, which crashes if it is freed at exit only.
            error.__traceback__ = None
            raise FileError(f"{self} is not a readable HDF5 file: {why}") from None


def opened(path: str | os.PathLike[str]) -> contextlib.AbstractContextManager[InputFile]:
    """Open a file for a block; one that is open already stays open."""
    return contextlib.nullcontext(path) if isinstance(path, InputFile) else InputFile(path)


def _decompressed(stream: BinaryIO, path: Path) -> bytes:
    packed = stream.read()
    try:
        data = gzip.GzipFile(fileobj=io.BytesIO(packed)).read(largest_expansion(len(packed)) + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise FileError(f"cannot decompress {path}: {first_line(error)}") from None
    check_expansion(str(path), len(data), len(packed))
    return data


def _archive(
    stream: BinaryIO, name: str, wanted: Collection[str] | None = None
) -> tuple[list[str], dict[str, NDArray[Any]]]:
    """Names of the arrays of a NumPy archive, and the arrays, or some of them, by their names.

    Pickled objects are never loaded: they could run code.
    """
    part = "the directory"
    try:
        stream.seek(0)
        if stream.read(4) not in (b"PK\x03\x04", b"PK\x05\x06") or not zipfile.is_zipfile(stream):
            raise FileError(f"{name} is not an npz archive, or is cut short")
        stored = stream.seek(0, os.SEEK_END)
        stream.seek(0)
        tables = {}
        with np.load(stream, allow_pickle=False) as archive:
            check_expansion(name, sum(member.file_size for member in archive.zip.infolist()), stored)
            for part in archive.files if wanted is None else [*filter(wanted.__contains__, archive.files)]:
                tables[part] = archive[part]
        return archive.files, tables
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
        tokenize.TokenError,  # one with a parenthesis that stays open
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise FileError(
            f"cannot read {first_line(part)} of the archive {name}: {first_line(error)}"
        ) from None
