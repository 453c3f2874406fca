"""Array types by content."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.int64]
Indices32 = NDArray[np.int32]
Mask = NDArray[np.bool_]
Points = NDArray[np.complex128]  # of the plane
