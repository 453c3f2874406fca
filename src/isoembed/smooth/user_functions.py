"""Evaluation of user-supplied functions on arrays, with checks of types and shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter


def called(name: str, function: Callable[..., Any], *arguments: NDArray[Any]) -> Any:
    """Call a function and return its value.

    Raises `InvalidParameter`: the function raises an error of types or shapes, as functions of one point do.
    """
    try:
        return function(*arguments)
    except InvalidParameter:
        raise
    except (TypeError, ValueError, IndexError) as error:
        shapes = " and ".join(str(array.shape) for array in arguments)
        raise InvalidParameter(
            f"{name} raises {type(error).__name__}: {error}. It is called with arrays, many points at once, "
            f"here of shape {shapes}: use np.sin instead of math.sin, and x[:, 0] for x of shape (n, 3)"
        ) from error


def array_of(name: str, values: ArrayLike, *, real: bool = True) -> NDArray[Any]:
    """Convert user input or the result of a function to an array of numbers, or raise `InvalidParameter`."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise InvalidParameter(f"{name} has values of several shapes") from None
    if array.dtype.kind not in "iuf" and (real or array.dtype.kind != "c"):
        kind = "complex values" if array.dtype.kind == "c" else f"values of type {array.dtype}"
        raise InvalidParameter(f"{name} has {kind}, not real numbers")
    return array


def real_values(name: str, function: Callable[..., Any], *arguments: Floats) -> Floats:
    """Values of a function as an array of real numbers; see `called` and `array_of`."""
    return array_of(name, called(name, function, *arguments)).astype(np.float64, copy=False)
