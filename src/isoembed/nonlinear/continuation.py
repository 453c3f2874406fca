"""Generic continuation: extrapolating predictors, and the loop over a decreasing penalty weight."""

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats


def extrapolated(known: list[tuple[float, Floats]], t: float) -> Floats:
    """Predictor of a path: the polynomial through points at given times, all different, at another t."""
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
        Takes x and mu, and returns the minimum nearby, or what is nearer to it.
    residual : callable
        What is to vanish without the penalty.
    mu : float
        The first weight.
    factor : float
        Of mu from one weight to the next.
    max_weights : int
    tolerance : float
        Residual at which it ends; it ends, too, where this hardly falls twice in a row.
    exhausted : callable
        Whether no more may be spent, asked after each weight.
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
