"""Continuation: predictors by extrapolation, and penalty continuation, whose weight vanishes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats

SLOW = 0.9  # share of the residual that two weights leave if the continuation is lost


def extrapolated(known: list[tuple[float, Floats]], t: float) -> Floats:
    """Predictor of a path: the polynomial in t through known points, evaluated at another t.

    Parameters
    ----------
    known : list of (float, ndarray)
        Times, all different, and points.
    t : float
    """
    times = np.array([s for s, _ in known])
    guess = np.zeros_like(known[0][1])
    for i, (s, x) in enumerate(known):
        others = np.delete(times, i)
        guess += np.prod((t - others) / (s - others)) * x
    return guess


def penalty_continuation(
    start: Floats,
    minimized: Callable[[Floats, float], Floats],
    residual: Callable[[Floats], float],
    mu: float,
    *,
    factor: float,
    max_weights: int,
    tolerance: float,
    exhausted: Callable[[], bool],
) -> tuple[Floats, float]:
    """Let the weight mu of a penalty vanish, from the minimum for one weight to that for the next.

    Parameters
    ----------
    start : ndarray
    minimized : callable
        Takes x and mu, and returns a minimum nearby, or a step to it.
    residual : callable
        What is to vanish without the penalty.
    mu : float
        The first weight.
    factor : float
        Of mu from one weight to the next.
    max_weights : int
    tolerance : float
        Residual at which to stop; also where it hardly falls twice in a row.
    exhausted : callable
        Whether no more may be spent, asked after each weight.

    Returns
    -------
    ndarray, float
        The last x, and its residual.
    """
    x, before, slow = start, np.inf, 0
    for _ in range(max_weights):
        x = minimized(x, mu)
        size = residual(x)
        slow = slow + 1 if size > SLOW * before else 0
        if size <= tolerance or slow == 2 or exhausted():
            break
        before = size
        mu *= factor
    return x, size
