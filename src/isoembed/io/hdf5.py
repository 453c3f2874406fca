"""Groups of HDF5 files and their arrays."""

from typing import Any

import numpy as np

from isoembed.io.expansion import check_expansion

HDF5_ENDINGS = (".h5", ".hdf5", ".he5")


def numbers_in(group: Any, path: object) -> dict[str, np.ndarray]:
    """Data sets of numbers right inside a group of a file, by their names."""
    return {
        name: array_of(item, path)
        for name, item in group.items()
        if hasattr(item, "shape") and item.shape is not None and item.dtype.kind in "iuf"
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


def groups_in(file: Any) -> dict[str, Any]:
    """Groups of a file by their paths, itself first with an empty one."""
    groups = {"": file}
    file.visititems(lambda name, item: groups.update({name: item}) if hasattr(item, "items") else None)
    return groups
