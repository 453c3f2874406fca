"""Validation of input: numbers, vectors, fields of spacetimes, points, and metrics at points."""

from collections.abc import Sequence
from dataclasses import fields
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidMetric, InvalidParameter


def positive_number(name: str, value: float) -> float:
    """Checked positive finite number.  Raises `InvalidParameter`: the value is not one."""
    number = numbers(value)
    if number.ndim != 0 or not (isfinite(number) and number > 0.0):
        raise InvalidParameter(f"{name} must be positive, not {value}")
    return float(number)


def vector(name: str, value: Sequence[float] | Floats) -> tuple[float, float, float]:
    """Checked triple of finite numbers.  Raises `InvalidParameter`: the value is not one."""
    array = numbers(value)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InvalidParameter(f"{name} must be three finite numbers, not {value}")
    x, y, z = array.tolist()
    return x, y, z


def unit_vector(name: str, value: Sequence[float]) -> tuple[float, float, float]:
    """Unit vector along a checked vector.  Raises `InvalidParameter`: it is not one, or zero."""
    x = np.array(vector(name, value))
    if not x.any():
        raise InvalidParameter(f"{name} must not be zero")
    x /= np.abs(x).max()
    a, b, c = map(float, x / np.linalg.norm(x))
    return a, b, c


def numbers(values: ArrayLike) -> Floats:
    """Array of real numbers; NaN of shape () if the input is not real."""
    try:
        array = np.asarray(values)
        return np.array(np.nan) if array.dtype.kind == "c" else array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        return np.array(np.nan)


def make_finite(instance: Any, name: str) -> None:
    """Convert the fields of a frozen dataclass to floats.  Raises `InvalidParameter`: one is not finite."""
    for parameter in fields(instance):
        setting = getattr(instance, parameter.name)
        value = numbers(setting)
        if value.ndim:
            axis = ", about the z-axis" if parameter.name == "spin" else ""
            raise InvalidParameter(f"{name}: {parameter.name} must be one number{axis}, not {setting}")
        if not isfinite(value):
            raise InvalidParameter(f"{name}: {parameter.name} must be finite, not {setting}")
        object.__setattr__(instance, parameter.name, float(value))


def refuse_points(bad: Mask, x: NDArray[Any], why: str) -> None:
    """Raise an `InvalidParameter` that names the first of the points x (n, 3) flagged as bad (n,)."""
    if bad.any():
        i = int(np.argmax(bad))
        raise InvalidParameter(f"point {i}, {written(x[i].real)}, {why}")


def check_slice(name: str, x: Floats, gamma: Floats) -> None:
    """Raise an `InvalidMetric` if gamma (n, 3, 3), at points x (n, 3), is not positive definite."""
    with np.errstate(invalid="ignore"):
        minor = gamma[:, 0, 0] * gamma[:, 1, 1] - gamma[:, 0, 1] * gamma[:, 1, 0]
    good = np.isfinite(gamma).all(axis=(1, 2)) & (gamma[:, 0, 0] > 0) & (minor > 0)
    good[good] = np.linalg.det(gamma[good]) > 0
    if not good.all():
        i = int(np.argmin(good))
        entries = ", ".join(f"{value:.6g}" for value in gamma[i][np.triu_indices(3)])
        missing = "; data are missing there or nearby" if np.isnan(gamma[i]).any() else ""
        raise InvalidMetric(
            f"{name} at {written(x[i])} is not positive definite: xx, xy, ... = {entries}{missing}"
        )


def check_symmetric(name: str, x: Floats, tensor: Floats, allowed: float) -> None:
    """Raise an `InvalidMetric` if a tensor (n, 3, 3), at points x (n, 3), is not symmetric.

    Parameters
    ----------
    name : str
        Name of the tensor, for the message.
    x, tensor : ndarray
    allowed : float
        Largest difference of two entries attributed to rounding.
    """
    uneven = np.abs(tensor - tensor.transpose(0, 2, 1)) > allowed
    if uneven.any():
        point, i, j = np.argwhere(uneven)[0]
        raise InvalidMetric(
            f"{name} at {written(x[point])} is not symmetric: its entry {'xyz'[i]}{'xyz'[j]} is "
            f"{tensor[point, i, j]:.6g}, and {'xyz'[j]}{'xyz'[i]} is {tensor[point, j, i]:.6g}"
        )


def check_finite(name: str, x: Floats, values: Floats) -> Floats:
    """Checked values (n, ...) at points x (n, 3).  Raises `InvalidMetric`: one is not finite."""
    good = np.isfinite(values.reshape(len(x), -1)).all(axis=1)
    if not good.all():
        raise InvalidMetric(
            f"{name} at {written(x[int(np.argmin(good))])} is not finite: data are missing there or nearby"
        )
    return values


def written(x: Floats) -> str:
    """Three numbers formatted for a message."""
    return f"({x[0]:.6g}, {x[1]:.6g}, {x[2]:.6g})"
