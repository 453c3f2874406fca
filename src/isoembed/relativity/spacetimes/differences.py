"""Central finite differences of functions in space, and checks of other derivatives against them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import written

SIXTH = (45.0 / 60.0, -9.0 / 60.0, 1.0 / 60.0)
EIGHTH = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)


def central_differences(
    f: Callable[[Floats], NDArray[Any]], x: Floats, step: float, weights: Sequence[float]
) -> Floats:
    """Derivatives (n, 3, ...) of f at x (n, 3), from central differences over one, two, ... steps."""
    steps = step * np.arange(1, len(weights) + 1)
    out = []
    for along in np.eye(3):
        shifts = np.multiply.outer(np.append(steps, -steps), along)
        values = f((x + shifts[:, None]).reshape(-1, 3))
        values = values.reshape(2, len(weights), len(x), *values.shape[1:])
        out.append(np.tensordot(weights, values[0] - values[1], 1))
    return np.asarray(np.stack(out, axis=1) / step)


def disagreement(
    f: Callable[[Floats], NDArray[Any]],
    x: Floats,
    gradient: Floats,
    relative: float,
    step: float = np.inf,
) -> tuple[str, float] | None:
    """Largest difference of a gradient from central differences that exceeds their error; None if none does.

    Parameters
    ----------
    f : callable
        Takes points (n, 3) and returns matrices (n, 3, 3).
    x : ndarray, shape (n, 3)
    gradient : ndarray, shape (n, 3, 3, 3)
        Gradient in the order [point, k, i, j], compared at four of the points.
    relative : float
        Largest admissible difference, relative to the largest component at a point.
    step : float
        Largest step of differences, if less than 1/256 of the extent of the points.

    Returns
    -------
    str
        The derivative, such as "d_x gamma_yz at (1, 0, 0) is 2".
    float
        The central difference.
    """
    size = float(np.ptp(x, axis=0).max(initial=0.0)) or float(np.abs(x).max(initial=0.0)) or 1.0
    largest = np.argmax(np.abs(gradient).reshape(len(x), -1).max(axis=1, initial=0.0)) if len(x) else 0
    some = np.unique([*np.linspace(0, len(x) - 1, 3).astype(int), largest])[: len(x)]
    x, stated = x[some], gradient[some]
    with np.errstate(all="ignore"):  # there may be no metric a step away
        steps = min(size / 256.0, step) / np.array([1.0, 8.0, 64.0])
        found = [central_differences(f, x, h, SIXTH) for h in steps]
        # Use the two successive steps that agree best, independent of scale and noise of the function.
        errors = [np.abs(b - a).max(axis=(1, 2, 3), keepdims=True) for a, b in pairwise(found)]
        best = int(np.argmin([np.max(error, initial=0.0) for error in errors]))
        larger = np.maximum(np.abs(found[best]), np.abs(stated)).max(axis=(1, 2, 3), keepdims=True)
        scale = np.abs(f(x)).max(initial=0.0) + np.abs(x).max(initial=0.0) * larger
        rounding = 64.0 * np.finfo(np.float64).eps * scale / steps[best]
        excess = np.abs(found[best] - stated) - relative * larger - 4.0 * errors[best] - rounding
    if not (excess > 0.0).any():  # also for NaN, which is no evidence
        return None
    point, k, i, j = np.unravel_index(np.nanargmax(excess), excess.shape)
    name = f"d_{'xyz'[k]} gamma_{''.join(sorted('xyz'[i] + 'xyz'[j]))}"
    given = f"{name} at {written(x[point])} is {stated[point, k, i, j]:.6g}"
    return given, float(found[best][point, k, i, j])
