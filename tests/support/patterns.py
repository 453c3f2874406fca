"""Random symmetric patterns, and what elimination makes of them."""

import numpy as np


def random_pattern(n, density, rng):
    """Symmetric, with a diagonal, connected or not."""
    upper = np.triu(rng.random((n, n)) < density, 1)
    return upper | upper.T | np.eye(n, dtype=bool)


def eliminated_pattern(pattern):
    """Where L has entries, by elimination of one unknown after the other."""
    filled = pattern.copy()
    for j in range(len(filled)):
        below = np.flatnonzero(filled[j + 1 :, j]) + j + 1
        filled[np.ix_(below, below)] = True
    return np.tril(filled)
