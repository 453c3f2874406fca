"""File names of an evolution: series, iteration and time, and patterns."""

import glob
import os
import re
import string
from dataclasses import dataclass
from pathlib import Path

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.io.hdf5 import enumerated

INTEGER = r"\d+"
DECIMAL = r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"
FIELDS = {"iteration": INTEGER, "time": DECIMAL}
NUMBER = re.compile(
    r"(?:^|[._-])(?P<word>iteration|it|time|t|n)?[_=]?(?P<number>\d+(?:\.\d+(?:[eE][+-]?\d+)?)?)(?=[._-]|$)"
)


@dataclass(frozen=True)
class NameParts:
    """Parts of the name of a file.

    Attributes
    ----------
    series : str
        Name without the number and the ending: "AhA" for ``AhA_0012.vtk``.
    iteration : int or None
    time : float or None
    """

    series: str
    iteration: int | None = None
    time: float | None = None


def name_parts(path: str | os.PathLike[str]) -> NameParts:
    """Series and number in the name of a file.

    The last number that stands alone, or behind ``it``, ``t``, ``n``, ``iteration`` or ``time``, is the
    iteration; behind ``time``, or with a decimal point, it is the time.  "1" of ``ah1.npz`` is a part of a
    name.
    """
    name = Path(path).name.removesuffix(".gz")
    stem = Path(name).stem if Path(name).suffix[1:2].isalpha() else name
    numbers = list(NUMBER.finditer(stem))
    if not numbers:
        return NameParts(stem)
    found = numbers[-1]
    series = (stem[: found.start()] + stem[found.end() :]).strip("._-")
    if found["word"] == "time" or "." in found["number"]:
        return NameParts(series, time=float(found["number"]))
    return NameParts(series, int(found["number"]))


def begins_with(path: Path, magic: bytes) -> bool:
    """Whether a path is a readable file that begins with some bytes."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False


def natural_order(name: str | os.PathLike[str]) -> list[str | int]:
    """Sort key for numerical order, with ah2 before ah10."""
    words = re.split(r"(\d+)", os.fspath(name))
    return [int(word) if k % 2 else word for k, word in enumerate(words)]


def is_pattern(text: str) -> bool:
    """Whether a text has fields like {iteration}."""
    return "{" in text


def matching_files(pattern: str) -> list[tuple[str, int | None, float | None]]:
    """Files whose names match a pattern, with the iteration and the time in them.

    Raises `InvalidParameter`: the pattern has other fields, or an invalid format.

    Parameters
    ----------
    pattern : str
        A path with ``{iteration}`` or ``{time}``, or both, once each; a format may follow as in Python:
        ``{iteration:06d}``, ``{time:.3f}``.

    Returns
    -------
    list of (str, int or None, float or None)
        Files sorted by name.
    """
    try:
        parsed = list(string.Formatter().parse(pattern))
    except ValueError as error:
        raise InvalidParameter(f"the pattern {pattern}: {error}") from None
    wild, regular, formats = "", "", dict[str, str]()
    for literal, name, spec, conversion in parsed:
        wild, regular = wild + glob.escape(literal), regular + re.escape(literal)
        if name is None:
            continue
        if name not in FIELDS or name in formats or conversion:
            raise InvalidParameter(
                f"the pattern {pattern} has the field {{{name}}}: "
                "it may have {iteration} and {time}, once each"
            )
        formats[name] = spec or ""
        wild, regular = wild + "*", regular + f"(?P<{name}>{FIELDS[name]})"
        try:
            format(0 if name == "iteration" else 0.0, spec or "")
        except ValueError as error:
            raise InvalidParameter(f"the pattern {pattern}: {error}") from None
    out = []
    for path in sorted(glob.glob(wild)):
        if (match := re.fullmatch(regular, path)) is None:
            continue
        iteration = int(match["iteration"]) if "iteration" in formats else None
        time = float(match["time"]) if "time" in formats else None
        values = {"iteration": iteration, "time": time}
        if all(not spec or format(values[name], spec) == match[name] for name, spec in formats.items()):
            out.append((path, iteration, time))
    return out


def files_in(folder: str | os.PathLike[str]) -> list[Path]:
    """Files right inside a folder, by name.  Raises `FileError`: it cannot be read."""
    return [path for path in entries_in(folder) if path.is_file()]


def entries_in(folder: str | os.PathLike[str]) -> list[Path]:
    """Files and folders right inside a folder, by name.  Raises `FileError`: it cannot be read."""
    try:
        return sorted(Path(folder).iterdir())
    except OSError as error:
        raise FileError(f"cannot read the folder {folder}: {error.strerror}") from None


def listing_of(folder: str | os.PathLike[str]) -> str:
    """Clause that lists the files in a folder, for error messages."""
    if not os.path.isdir(folder):
        return f"there is no folder {folder}"
    names = [path.name for path in files_in(folder)]
    return f"in {folder} there are {enumerated(names)}" if names else f"there are no files in {folder}"
