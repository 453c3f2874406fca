"""Input files, opened once: decompression, text encoding, arrays by name."""

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
from isoembed.io.decompression_limit import check_expansion, largest_expansion
from isoembed.io.files import FileError, Tables, first_line, input_ending, open_input
from isoembed.io.hdf5 import HDF5_ENDINGS, array_of, enumerated, groups_in, listing, numbers_in

GZIP = b"\x1f\x8b"
NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f-\x9f]")  # control characters, including those of Latin-1


class InputFile(os.PathLike[str]):
    """A file opened once, decompressed if gzipped; a context manager and a path.

    Parameters
    ----------
    path : path

    Attributes
    ----------
    path : Path
    ending : str
        Suffix of the name in lower case, with its dot, ignoring ``.gz``.
    head : str
        Beginning of the file as text, for recognizing formats.

    Raises
    ------
    FileError
        The file does not exist, is a folder, or cannot be read or decompressed.
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
        """Text of the file, in UTF-8, UTF-16 with a byte order mark, or Latin-1.

        Raises
        ------
        FileError
            The file is not text.
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
        """Arrays of a ``.npz`` archive by name, or numeric arrays of an HDF5 file, by group.

        The root group, the only one of an archive, is ``""``.

        Raises
        ------
        FileError
            The file is damaged, or has another format.
        """
        if self.ending not in HDF5_ENDINGS:
            return {"": _archive(self._stream, str(self))[1]}
        with self.hdf5() as file:
            return {name: numbers_in(group, self) for name, group in groups_in(file).items()}

    @property
    def names(self) -> list[str]:
        """Names of the arrays of a ``.npz`` archive, or of the root entries of an HDF5 file.

        Raises
        ------
        FileError
            See `arrays`.
        """
        if self.ending not in HDF5_ENDINGS:
            return _archive(self._stream, str(self), ())[0]
        with self.hdf5() as file:
            return [*file, *file.attrs]

    def some(self, wanted: Collection[str]) -> Tables:
        """Read only the arrays with the given names, as far as they exist.

        Parameters
        ----------
        wanted : collection of str
            Names of arrays of a ``.npz`` archive, or of root data sets or attributes of an HDF5 file.

        Raises
        ------
        FileError
            See `arrays`.
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
        """Open an HDF5 file with h5py; errors of h5py in the block become a `FileError`.

        Raises
        ------
        FileError
            The file is damaged or not HDF5, or h5py is not installed.
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
        except (OSError, KeyError, RuntimeError, TypeError, ValueError) as error:  # raised by h5py if damaged
            why = first_line(" ".join(str(error).split()).strip("'\""))
            # Its frames hold h5py's driver of open files, which crashes if freed only at exit.
            error.__traceback__ = None
            raise FileError(f"{self} is not a readable HDF5 file: {why}") from None


def opened(path: str | os.PathLike[str]) -> contextlib.AbstractContextManager[InputFile]:
    """Context manager that opens a file; an already open one stays open."""
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
    """Names of all arrays of a NumPy archive, and the wanted arrays (default: all) by name.

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
        MemoryError,  # a header that claims more than exists
        KeyError,
        RuntimeError,  # encrypted
        NotImplementedError,  # unknown compression
        SyntaxError,  # a header that is no Python literal
        tokenize.TokenError,  # a header with an unclosed parenthesis
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise FileError(
            f"cannot read {first_line(part)} of the archive {name}: {first_line(error)}"
        ) from None
