"""Evaluation of user-supplied functions on arrays, with checks of types and shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter


def called(what: str, function: Callable[..., Any], *arguments: NDArray[Any]) -> Any:
    """Call a function and return its value.

    Raises `InvalidParameter`: it raises a TypeError, as functions of single numbers do.
    """
    try:
        return function(*arguments)
    except TypeError as error:
        raise InvalidParameter(
            f"{what} raises TypeError: {error}. It is called with arrays: use np.sin instead of math.sin"
        ) from error


def array_of(what: str, given: ArrayLike, *, real: bool = True) -> NDArray[Any]:
    """Convert what a user or a function gave to an array of numbers, or raise `InvalidParameter`."""
    try:
        array = np.asarray(given)
    except ValueError:
        raise InvalidParameter(f"{what} has values of several shapes") from None
    if array.dtype.kind not in "iuf" and (real or array.dtype.kind != "c"):
        kind = "complex values" if array.dtype.kind == "c" else f"values of type {array.dtype}"
        raise InvalidParameter(f"{what} has {kind}, not real numbers")
    return array


def real_values(what: str, function: Callable[..., Any], *arguments: Floats) -> Floats:
    """The values of a function as an array of real numbers; see `called` and `array_of`."""
    return array_of(what, called(what, function, *arguments)).astype(np.float64, copy=False)
