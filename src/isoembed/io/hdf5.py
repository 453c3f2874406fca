"""Groups of HDF5 files and their arrays."""

from collections.abc import Collection
from typing import Any

import numpy as np

from isoembed.io.expansion import check_expansion

LISTED = 8  # names that a refusal enumerates
HDF5_ENDINGS = (".h5", ".hdf5", ".he5")


def numbers_in(group: Any, path: object) -> dict[str, np.ndarray]:
    """Data sets of numbers right inside a group of a file, by their names."""
    return {
        name: array_of(item, path)
        for name, item in group.items()
        if isinstance(name, str)  # of damaged files some are bytes
        and hasattr(item, "shape")
        and item.shape is not None
        and item.dtype.kind in "iuf"
    }


def array_of(data: Any, path: object) -> Any:
    """The array that a data set of a file holds.

    Raises
    ------
    FileError
        It is larger than what is stored of it can be.
    """
    check_expansion(f"{data.name} of {path}", data.nbytes, data.id.get_storage_size())
    return data[()]


def listing(file: Any) -> str:
    """The data sets of a file by their paths, the first of many, or its groups where there are none."""
    sets: list[str] = []
    groups: list[str] = []
    file.visititems(lambda name, item: (groups if hasattr(item, "items") else sets).append(_written(name)))
    if not sets:
        return f"no data sets, but the groups {enumerated(groups)}" if groups else "nothing"
    return f"the data sets {enumerated(sets)}"


def _written(name: str | bytes) -> str:
    """A name, which is bytes in some damaged files."""
    return name if isinstance(name, str) else name.decode("utf-8", errors="replace")


def enumerated(names: Collection[str]) -> str:
    """The first of some names, and how many there are more."""
    first = ", ".join(list(names)[:LISTED])
    return first if len(names) <= LISTED else f"{first} and {len(names) - LISTED} more"


def groups_in(file: Any) -> dict[str, Any]:
    """Groups of a file by their paths, itself first with an empty one."""
    groups = {"": file}
    file.visititems(lambda name, item: groups.update({name: item}) if hasattr(item, "items") else None)
    return groups
