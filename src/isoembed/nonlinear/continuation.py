"""Generic continuation: extrapolating predictors, and the loop over a decreasing penalty weight."""

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats


def extrapolated(history: list[tuple[float, Floats]], t: float) -> Floats:
    """Polynomial predictor of a path at time t, from points at given distinct times."""
    times = np.array([s for s, _ in history])
    guess = np.zeros_like(history[0][1])
    for i, (s, x) in enumerate(history):
        others = np.delete(times, i)
        guess += np.prod((t - others) / (s - others)) * x
    return guess


def penalty_continuation(
    start: Floats,
    minimized: Callable[[Floats, float], Floats],
    residual: Callable[[Floats], float],
    mu: float,
    factor: float,
    max_weights: int,
    tolerance: float,
    exhausted: Callable[[], bool],
) -> tuple[Floats, float]:
    """Minimize with a decreasing penalty weight mu; return the last x and its residual.

    Parameters
    ----------
    start : ndarray
    minimized : callable
        Takes x and mu, and returns a nearby minimum, or an approximation of it.
    residual : callable
        Residual, which vanishes at a solution without the penalty.
    mu : float
        Initial weight.
    factor : float
        Ratio of successive weights.
    max_weights : int
    tolerance : float
        Residual at which the loop ends; it also ends after two weights in a row with little progress.
    exhausted : callable
        Whether the budget is used up, called after each weight.
    """
    x, before, slow = start, np.inf, 0
    for _ in range(max_weights):
        x = minimized(x, mu)
        size = residual(x)
        slow = slow + 1 if size > 0.9 * before else 0
        if size <= tolerance or slow == 2 or exhausted():
            break
        before = size
        mu *= factor
    return x, size
