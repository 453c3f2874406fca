"""Validation of displacements, length changes and length errors."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.metric.polyhedral import PolyhedralMetric


def checked(values: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    """Finite array whose last axes have the given shape; raises InvalidParameter otherwise."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape[array.ndim - len(shape) :] != shape or array.ndim < len(shape):
        raise InvalidParameter(f"the {name} have the shape {array.shape}, which does not end in {shape}")
    if not np.isfinite(array).all():
        i = np.unravel_index(int(np.argmin(np.isfinite(array))), array.shape)
        raise InvalidParameter(f"the {name} at {list(map(int, i))} are {array[i]}, which is not finite")
    return array


def checked_errors(metric: PolyhedralMetric, errors: ArrayLike) -> Floats:
    """Errors of the lengths as an array, (E,), from a scalar or one value per edge.

    Raises
    ------
    InvalidParameter
        The errors have another shape, are negative or not finite.
    """
    array, shape = np.asarray(errors, dtype=np.float64), metric.lengths.shape
    sigma = checked(np.broadcast_to(array, shape) if array.ndim == 0 else array, shape, "errors")
    if sigma.ndim > 1:
        raise InvalidParameter(f"the errors have the shape {sigma.shape}, not {shape}")
    if (sigma < 0).any():
        e = int(np.argmax(sigma < 0))
        raise InvalidParameter(f"the error of edge {e} is {sigma[e]}, which is negative")
    return sigma
