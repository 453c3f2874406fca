"""Groups of HDF5 files and their arrays."""

from collections.abc import Collection
from typing import Any

import numpy as np

from isoembed.io.decompression_limit import check_expansion

LISTED = 8  # names listed in an error message
HDF5_ENDINGS = (".h5", ".hdf5", ".he5")


def numbers_in(group: Any, path: object) -> dict[str, np.ndarray]:
    """Numeric data sets directly in a group of a file, by name."""
    return {
        name: array_of(item, path)
        for name, item in group.items()
        if isinstance(name, str)  # bytes in some damaged files
        and hasattr(item, "shape")
        and item.shape is not None
        and item.dtype.kind in "iuf"
    }


def array_of(data: Any, path: object) -> Any:
    """Array stored in a data set.

    Raises
    ------
    FileError
        The array is larger than its stored bytes permit.
    """
    check_data_set(data, path, data.nbytes)
    return data[()]


def check_data_set(data: Any, path: object, size: int) -> None:
    """Raise a `FileError` if a part of a data set, of a given size in bytes, expands too far."""
    check_expansion(f"{data.name} of {path}", size, data.id.get_storage_size())


def listing(file: Any) -> str:
    """Description of the data sets of a file, or of its groups if it has none, for error messages."""
    sets: list[str] = []
    groups: list[str] = []
    file.visititems(lambda name, item: (groups if hasattr(item, "items") else sets).append(text_of(name)))
    if not sets:
        return f"no data sets, but the groups {enumerated(groups)}" if groups else "nothing"
    return f"the data sets {enumerated(sets)}"


def text_of(value: Any) -> str:
    """Text of a name or an attribute, which may be bytes."""
    return value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)


def enumerated(names: Collection[str]) -> str:
    """The first few names, and the number of the others."""
    first = ", ".join(list(names)[:LISTED])
    return first if len(names) <= LISTED else f"{first} and {len(names) - LISTED} more"


def groups_in(file: Any) -> dict[str, Any]:
    """Groups of a file by path; the file itself has the empty path."""
    groups = {"": file}
    file.visititems(lambda name, item: groups.update({name: item}) if hasattr(item, "items") else None)
    return groups
