"""Groups of HDF5 files and their arrays."""

from typing import Any

import numpy as np

HDF5_ENDINGS = (".h5", ".hdf5", ".he5")


def numbers_in(group: Any) -> dict[str, np.ndarray]:
    """Data sets of numbers right inside a group, by their names."""
    return {
        name: item[()]
        for name, item in group.items()
        if hasattr(item, "shape") and item.shape is not None and item.dtype.kind in "iuf"
    }


def groups_in(file: Any) -> dict[str, Any]:
    """Groups of a file by their paths, itself first with an empty one."""
    groups = {"": file}
    file.visititems(lambda name, item: groups.update({name: item}) if hasattr(item, "items") else None)
    return groups
