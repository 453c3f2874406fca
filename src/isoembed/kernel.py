"""Compiled functions: how they are compiled, and where the code of one process is kept for the next."""

import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba import config, njit
from numba.core.caching import FunctionCache


def kernel(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Decorator of functions that numba compiles on the first call with arguments of new types.

    The code is kept where numba keeps it: in the folder that ``NUMBA_CACHE_DIR`` names, else beside the
    source, else in the user's cache folder.  Where it can write to none of them, as services without a home
    cannot, a folder below the temporary one takes their place; without that, nothing is kept.

    A division by zero is infinite.  As an exception it would be another way out of a function, on which
    numba counts the references to every array of a named tuple: to flip 100,000 vertices to Delaunay then
    takes 40 % longer than with loose arrays.  As it is it takes as long, where named tuples do not hold named
    tuples.

    Parameters
    ----------
    function : callable
    **options
        Others of `numba.njit`.
    """
    if function is None:
        return lambda function: kernel(function, **options)
    compiled: Any = njit(function, error_model="numpy", **options)
    with suppress(OSError, RuntimeError):  # there is no place for it
        compiled._cache = _cache(function)
    return compiled


class _Cache(FunctionCache):
    """The kept code of a function.  If it cannot be read or written, the function is compiled anew."""

    def load_overload(self, *compiled_for: Any) -> Any:
        try:
            return super().load_overload(*compiled_for)
        except OSError:  # closed to us
            return None
        except (EOFError, pickle.UnpicklingError):  # cut short
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, *compiled: Any) -> None:
        with suppress(OSError, EOFError, pickle.UnpicklingError):  # a full disk, and what it left
            super().save_overload(*compiled)


def _cache(function: Callable[..., Any]) -> _Cache:
    try:
        return _Cache(function)
    except RuntimeError:  # numba knows no place
        config.CACHE_DIR = _own_folder()  # type: ignore[attr-defined]
        return _Cache(function)


def _own_folder() -> str:
    """Folder below the temporary one which is closed to others: what is in a cache is run.

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
    return str(folder)
