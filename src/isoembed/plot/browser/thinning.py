"""Selection of the film frames in a browser page."""

from collections.abc import Sequence

import numpy as np


def thinned(stages: Sequence[str], limit: int) -> list[int]:
    """Choose frames: the first and the last of every stage, and of the others evenly many.

    Parameters
    ----------
    stages : sequence of str
        The stage of each frame, in order; a stage that comes back counts again.
    limit : int
        How many frames, at least 1.  Where there are more first and last ones than that, they are thinned
        evenly, too; the last frame is always kept.

    Returns
    -------
    list of int
        Indices, ascending.
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
    """Choose `count` of 0 .. n - 1 evenly, with both ends; or inner ones of them, counted from 0."""
    if count == 1:
        return [n - 1]
    chosen = np.rint(np.linspace(0, n - 1, count)).astype(int).tolist()
    return [k - 1 for k in chosen[1:-1]] if inner else chosen
