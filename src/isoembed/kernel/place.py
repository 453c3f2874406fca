"""Where compiled code is kept from one process to the next."""

import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any


def is_kept(function: Callable[..., Any]) -> bool:
    """Whether there is code of a function, for some types, that is not older than its file; without numba."""
    code = function.__code__
    source = Path(code.co_filename)
    python = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"
    qualified = function.__qualname__.replace("<", "").replace(">", "")
    index = f"{source.stem}.{qualified}-{code.co_firstlineno}.{python}.nbi"  # numba's name for it
    kept = _indices(source.parent).get(index)
    return kept is not None and kept >= _time(source)


@lru_cache
def place_of(parent: Path) -> Path | None:
    """Where the code of the files of a folder is kept: the first of the places that can be written to."""
    return next(filter(_is_writable, _places(parent)), None)


def _is_writable(place: Path) -> bool:
    while not place.exists() and place != place.parent:  # it will be made
        place = place.parent
    try:
        tempfile.TemporaryFile(dir=place).close()
    except OSError:
        return False
    return True


@lru_cache
def _time(source: Path) -> float:
    return source.stat().st_mtime if source.exists() else float("inf")


@lru_cache
def _indices(parent: Path) -> dict[str, float]:
    """Names and times of what is kept of the files of a folder."""
    place = place_of(parent)
    if place is None or not place.exists():
        return {}
    with os.scandir(place) as entries:
        return {entry.name: entry.stat().st_mtime for entry in entries if entry.name.endswith(".nbi")}


def _places(parent: Path) -> Iterator[Path]:
    below = f"{parent.name}_{hashlib.sha1(str(parent).encode()).hexdigest()}"
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(named, below)
    yield parent / "__pycache__"
    home = os.environ.get("LOCALAPPDATA") if os.name == "nt" else os.environ.get("XDG_CACHE_HOME")
    with suppress(RuntimeError):  # there is no home
        yield (Path(home) if home else Path.home() / ".cache") / "isoembed" / below
    with suppress(OSError):
        yield _own_folder() / below


def _own_folder() -> Path:
    """Folder below the temporary one which is closed to others: what is kept there is run.

    Raises
    ------
    OSError
        It cannot be made, or somebody else's is there.
    """
    if not hasattr(os, "getuid"):  # Windows
        raise PermissionError("there is no telling who may write there")
    folder = Path(tempfile.gettempdir(), f"isoembed-{os.getuid()}")
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise PermissionError(f"{folder} is not ours alone")
    return folder
