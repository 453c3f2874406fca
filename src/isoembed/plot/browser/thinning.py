"""Selection of the film frames in a browser page."""

from collections.abc import Sequence

import numpy as np


def thinned(stages: Sequence[str], limit: int) -> list[int]:
    """Select frames: the first and last of every stage, and evenly spaced others.

    Parameters
    ----------
    stages : sequence of str
        Stage of each frame, in order; a repeated stage counts again.
    limit : int
        Largest number of frames, at least 1.  If there are more first and last frames, these are thinned
        evenly, too; the last frame is always selected.

    Returns
    -------
    list of int
        Indices of the selected frames, ascending.
    """
    n = len(stages)
    if n <= limit:
        return list(range(n))
    ends = [
        k for k in range(n) if k in (0, n - 1) or stages[k] != stages[k - 1] or stages[k] != stages[k + 1]
    ]
    if len(ends) >= limit:
        return [ends[k] for k in _evenly(len(ends), limit)]
    others = sorted(set(range(n)) - set(ends))
    return sorted(ends + [others[k] for k in _evenly(len(others) + 2, limit - len(ends) + 2, inner=True)])


def _evenly(n: int, count: int, *, inner: bool = False) -> list[int]:
    """Select `count` of 0 .. n - 1 evenly, including both ends; or only inner ones, numbered from 0."""
    if count == 1:
        return [n - 1]
    chosen = np.rint(np.linspace(0, n - 1, count)).astype(int).tolist()
    return [k - 1 for k in chosen[1:-1]] if inner else chosen
