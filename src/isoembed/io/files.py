"""File errors in one sentence each, checks of file name endings, and atomic writing."""

import contextlib
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from isoembed.similar_names import did_you_mean

Tables = Mapping[str, Any]
"""Arrays of a file by name: ``faces``, ``edges``, ``lengths``, ``vertices`` and vertex data."""

Writer = Callable[[Path], object]
"""Function that writes one file to the given (temporary) path."""


QUOTED = 120  # characters quoted from another package's message, which may contain a whole damaged file


class FileError(ValueError):
    """A file that cannot be read or written, or whose contents do not match its ending.

    Control characters in the message are escaped.
    """

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class AmbiguousFileError(FileError):
    """A file with several candidates for one requested object.

    Attributes
    ----------
    sentence : str
        Description of the contents.
    parameter : str
        Parameter that selects one; the message ends with it.
    """

    def __init__(self, sentence: str, parameter: str) -> None:
        super().__init__(f"{sentence}, by {parameter}")
        self.sentence, self.parameter = sentence, parameter


def first_line(error: object) -> str:
    """First line of another package's error message, shortened, with control characters escaped."""
    line = printable(next(iter(str(error).splitlines()), ""))
    return line if len(line) <= QUOTED else line[: QUOTED - 3] + "..."


def printable(text: str) -> str:
    """Text with unprintable characters escaped."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def ending(path: str | os.PathLike[str]) -> str:
    """Suffix of a file name in lower case, with its dot."""
    return Path(path).suffix.lower()


def input_ending(path: str | os.PathLike[str]) -> str:
    """Suffix of an input file's name, ignoring ``.gz``."""
    return ending(Path(path).with_suffix("") if ending(path) == ".gz" else path)


def check_ending(
    path: str | os.PathLike[str],
    endings: Collection[str],
    of: Callable[[str | os.PathLike[str]], str] = input_ending,
) -> None:
    """Raise an error if a file name has an unknown ending.

    Raises
    ------
    FileError
        The message names the known endings or, if the file does not exist, one with a similar name.
    """
    if (found := of(path)) not in endings:
        if of is input_ending and not Path(path).exists() and (similar := _similar(Path(path))):
            raise FileError(f"there is no file {path}{similar}")
        actual = f"the ending {found!r}" if found else "no ending"
        question = did_you_mean(found, endings, 0.7)
        raise FileError(f"{path} has {actual}, not one of {' '.join(endings)}{question}")


def _similar(path: Path) -> str:
    """Suggestion of a similarly named file in the same folder, as the end of a sentence."""
    there = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
    return did_you_mean(path.name, there, 0.8)


def check_target(path: str | os.PathLike[str]) -> None:
    """Raise an error if nothing can be written to a path.

    Raises
    ------
    FileError
        The folder does not exist, is not writable or is full, or the path is not a regular file, or it is
        another user's file in a folder with the sticky bit.
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
            trial.write(bytes(4096))  # even a full disk accepts an empty file
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror}") from None
    if target.exists() and not _may_replace(target):
        raise FileError(f"cannot write {path}: it belongs to another user")


def _may_replace(target: Path) -> bool:
    """Whether the sticky bit of the folder permits replacing the file."""
    folder = target.parent.stat()
    protected = folder.st_mode & stat.S_ISVTX and hasattr(os, "geteuid")
    return not protected or os.geteuid() in (0, folder.st_uid, target.stat().st_uid)


def open_input(path: Path) -> BinaryIO:
    """Open a file for reading.

    Raises
    ------
    FileError
        The file does not exist, is a folder, or is not readable.
    """
    try:
        return path.open("rb", buffering=1 << 16)
    except FileNotFoundError:
        raise FileError(f"there is no file {path}{_similar(path)}") from None
    except IsADirectoryError:
        raise FileError(f"{path} is a folder, not a file") from None
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}") from None


@contextlib.contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Context manager in which errors of reading a file become a `FileError`.

    Raises
    ------
    FileError
        The operating system refused, or the contents are damaged.
    """
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}") from None
    except (StopIteration, ValueError, KeyError, TypeError, IndexError):
        raise FileError(f"{path} is cut short or damaged") from None


def write_atomically(writers: Mapping[Path, Writer]) -> None:
    """Write several files atomically: all of them or, if any fails, none.

    Parameters
    ----------
    writers : mapping of path to Writer
        Each is called with a temporary path in the same folder, with the same ending; after all have
        returned, the temporary files replace the targets.

    Raises
    ------
    FileError
        The operating system refused: no space, no permission, no such folder.
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
    """Resolve symbolic links: the link stays, its target is replaced.

    Raises
    ------
    FileError
        The path is invalid.
    """
    try:
        target = Path(path).resolve()
        target.exists()
    except (OSError, RuntimeError) as error:  # a name too long, a cycle of links
        raise FileError(f"cannot write {path}: {error}") from None
    return target
