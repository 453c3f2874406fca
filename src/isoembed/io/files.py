"""File errors in one sentence each, and atomic writing."""

import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from isoembed.similar_names import did_you_mean

Tables = Mapping[str, Any]
"""Named arrays of a file: ``faces``, ``edges``, ``lengths``, ``vertices`` and data at the vertices."""

Writer = Callable[[Path], object]
"""Writes one file under the (temporary) name that it is given."""


QUOTED = 120  # characters of what another package says: it may quote all of a damaged file
TRIAL = 4096  # bytes: a full disk takes an empty file


class FileError(ValueError):
    """A file that cannot be read or written, or is not what its ending says.

    Control characters that the message quotes of a file are escaped.
    """

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class AmbiguousFileError(FileError):
    """A file that holds several of what one is wanted of.

    Attributes
    ----------
    sentence : str
        What it holds.
    parameter : str
        The parameter that chooses one; the message ends with it.
    """

    def __init__(self, sentence: str, parameter: str) -> None:
        super().__init__(f"{sentence}, by {parameter}")
        self.sentence, self.parameter = sentence, parameter


def first_line(error: object) -> str:
    """The beginning of what another package says of a file, on one line; bytes of the file are escaped."""
    line = printable(next(iter(str(error).splitlines()), ""))
    return line if len(line) <= QUOTED else line[: QUOTED - 3] + "..."


def printable(text: str) -> str:
    """Text with escape sequences for characters that cannot be printed."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def ending(path: str | os.PathLike[str]) -> str:
    """Ending of a file name in lower case, with its dot."""
    return Path(path).suffix.lower()


def input_ending(path: str | os.PathLike[str]) -> str:
    """Ending of the name of a file to read: that before ``.gz`` where there is one."""
    return ending(Path(path).with_suffix("") if ending(path) == ".gz" else path)


def check_ending(
    path: str | os.PathLike[str],
    known: Collection[str],
    of: Callable[[str | os.PathLike[str]], str] = input_ending,
) -> None:
    """Refuse a file name whose ending is not among the known ones.

    Raises
    ------
    FileError
        Naming the endings that are known, or a file that has a similar name if there is none of this one.
    """
    if (found := of(path)) not in known:
        if of is input_ending and not Path(path).exists() and (similar := _similar(Path(path))):
            raise FileError(f"there is no file {path}{similar}")
        what = f"the ending {found!r}" if found else "no ending"
        raise FileError(f"{path} has {what}, not one of {' '.join(known)}{did_you_mean(found, known, 0.7)}")


def _similar(path: Path) -> str:
    """The end of a sentence about a file that is not there: one of a similar name in its folder."""
    there = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
    return did_you_mean(path.name, there, 0.8)


def check_target(path: str | os.PathLike[str]) -> None:
    """Refuse a file name under which nothing can be written.

    Raises
    ------
    FileError
        The folder does not exist, is closed to us or full, or the name belongs to something that is not an
        ordinary file, or to a file of somebody else in a folder where only its owner may replace it.
    """
    target = _target(path)
    if target.exists() and not target.is_file():
        raise FileError(
            f"cannot write {path}: it is {'a folder' if target.is_dir() else 'not an ordinary file'}"
        )
    if not target.parent.is_dir():
        raise FileError(f"cannot write {path}: there is no folder {target.parent}")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise FileError(f"cannot write {path}: no permission to write in {target.parent}")
    try:
        with tempfile.TemporaryFile(dir=target.parent) as trial:
            trial.write(bytes(TRIAL))
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror}") from None
    if target.exists() and not _may_replace(target):
        raise FileError(f"cannot write {path}: it belongs to somebody else")


def _may_replace(target: Path) -> bool:
    """Whether the bit of folders like /tmp that protects files from all but their owners leaves it to us."""
    folder = target.parent.stat()
    protected = folder.st_mode & stat.S_ISVTX and hasattr(os, "geteuid")
    return not protected or os.geteuid() in (0, folder.st_uid, target.stat().st_uid)


def open_input(path: Path) -> BinaryIO:
    """Open a file for reading.

    Raises
    ------
    FileError
        There is no such file, it is a folder, or we may not read it.
    """
    try:
        return path.open("rb", buffering=1 << 16)
    except FileNotFoundError:
        raise FileError(f"there is no file {path}{_similar(path)}") from None
    except IsADirectoryError:
        raise FileError(f"{path} is a folder, not a file") from None
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}") from None


def write_atomically(writers: Mapping[Path, Writer]) -> None:
    """Write several files, each whole, and none of them if any fails.

    Parameters
    ----------
    writers : mapping of path to Writer
        Each is called with a temporary name in the same folder, with the same ending; when all have
        returned, the temporary files take their places.

    Raises
    ------
    FileError
        The system refused: no space, no permission, no such folder.
    """
    temporaries = {
        path: _target(path).with_name(f".isoembed-{secrets.token_hex(8)}{Path(path).suffix}")
        for path in writers
    }
    path = Path()
    try:
        for path, temporary in temporaries.items():
            writers[path](temporary)
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
            if _target(path).exists():
                shutil.copymode(_target(path), temporary)
        for path, temporary in temporaries.items():
            temporary.replace(_target(path))
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror or error}") from None
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


def _target(path: str | os.PathLike[str]) -> Path:
    """File behind symbolic links: the link stays, its file is replaced.

    Raises
    ------
    FileError
        There can be no such file.
    """
    try:
        target = Path(path).resolve()
        target.exists()
    except (OSError, RuntimeError) as error:  # a name too long, links in a circle
        raise FileError(f"cannot write {path}: {error}") from None
    return target
