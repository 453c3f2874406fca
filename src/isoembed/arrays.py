"""Array types by content, and parts of long arrays."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.int64]
Indices32 = NDArray[np.int32]
Mask = NDArray[np.bool_]
Points = NDArray[np.complex128]  # of the plane


def chunks(count: int, size: int) -> Iterator[slice]:
    """Parts of an array of that many rows, of at most `size` rows each."""
    return (slice(begin, begin + size) for begin in range(0, count, size))
