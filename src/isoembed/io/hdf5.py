"""HDF5 files, opened with h5py where it is installed."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.io.files import FileError, check_input

HDF5_ENDINGS = (".h5", ".hdf5", ".he5")


@contextlib.contextmanager
def hdf5_file(path: str | os.PathLike[str]) -> Iterator[Any]:
    """Open an HDF5 file for reading.

    Raises
    ------
    FileError
        There is no such file, it is damaged or no HDF5 file, or h5py is not installed.
    """
    check_input(Path(path))
    try:
        import h5py
    except ImportError:
        raise FileError(f"reading {path} needs h5py: pip install 'isoembed[hdf5]'") from None
    try:
        with h5py.File(path, "r") as file:
            yield file
    except FileError:
        raise
    except (OSError, KeyError, RuntimeError) as error:  # h5py's ways to say that data are damaged
        why = " ".join(str(error).split()).strip("'\"")
        raise FileError(f"{path} is not a readable HDF5 file: {why}") from None


def numbers_in(group: Any) -> dict[str, np.ndarray]:
    """The data sets of numbers right inside a group, by their names."""
    return {
        name: item[()]
        for name, item in group.items()
        if hasattr(item, "shape") and item.shape is not None and item.dtype.kind in "iuf"
    }


def groups_in(file: Any) -> dict[str, Any]:
    """A file's groups, itself first with an empty name, by their paths."""
    groups = {"": file}
    file.visititems(lambda name, item: groups.update({name: item}) if hasattr(item, "items") else None)
    return groups
