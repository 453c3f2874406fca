"""Guided adiabatic pull-back, GAP (paper, section 2.3), in a fixed number of steps."""

from collections.abc import Callable, Iterable, Iterator

from isoembed.aim.anneal import Annealed
from isoembed.arrays import Floats
from isoembed.nonlinear.continuation import extrapolated


def pull_back(
    start: Floats, times: Iterable[float], relax: Callable[[Floats, float], Annealed]
) -> Iterator[tuple[float, Annealed]]:
    """Follow the metrics rho_t from P_{t_f}, one surface after another.

    The initial guess is the previous surface for the steps j = 1, 2, 3, then the polynomial through the three
    previous surfaces.

    Parameters
    ----------
    start : ndarray, shape (V, 3)
        P_{t_f}, embedded at the first time.
    times : iterable of float
        t_j / t_f, falling from 1.
    relax : callable
        Function that anneals a guess at a given time.

    Yields
    ------
    float, Annealed
        Each time after the first, over t_f, and the surface P_t.
    """
    moments = iter(times)
    history = [(next(moments), start)]
    for t in moments:
        guess = extrapolated(history[-3:], t) if len(history) > 3 else history[-1][1]
        annealed = relax(guess, t)
        history = [*history[-3:], (t, annealed.vertices)]
        yield t, annealed
