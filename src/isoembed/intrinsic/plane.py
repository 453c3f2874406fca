"""Plane coordinates of points of a plane in space, as seen from the side of its normal."""

from typing import cast

import numpy as np

from isoembed.arrays import Floats


def flattened(arms: Floats, normal: Floats) -> Floats:
    """Coordinates in a plane in space, as seen from the side of its normal, shape (n, 2).

    Parameters
    ----------
    arms : ndarray, shape (n, 3)
        Vectors from one point of the plane to others.
    normal : ndarray, shape (3,)
        Normal of any length.
    """
    normal = normal / np.linalg.norm(normal)
    along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    along /= np.linalg.norm(along)
    return cast(Floats, arms @ np.column_stack([along, np.cross(normal, along)]))
