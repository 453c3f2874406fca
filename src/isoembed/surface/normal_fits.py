"""Local polynomial fits in batches, by normal equations.

The fits are those of `local_fit`, which orthogonalizes the columns of one fit after the other.  Here the fits
of a few hundred vertices go through the same steps side by side, so that each step is one operation on rows
of numbers, a number a fit: the moments of their weighted points, Cholesky's factors
of the normal equations, and the weights.  The normal equations square the condition of a fit; a fit that they
might spoil is left to the other way.
"""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.surface.fit_loops import fewest, weigh

NEAR = 0.5  # squared edges: a point p has the weight 1 / (NEAR + |p|^2)
SIDE_BY_SIDE = 128  # fits made at a time: their moments stay in a cache
MAX_POINTS = 128  # of fits that are made side by side
TWO_RINGS = 14  # points: fewer in two rings, and a cubic gets a third: 4 to spare
THREE_RINGS = 30  # points: more than two rings have, so that a quintic gets a third


def normal_weights(indptr: Indices, charts: Floats, degree: int, weights: Floats) -> Mask:
    """Fill in the weights of the points in the constant terms of the fits, where that can be done safely.

    The points of fit i are ``charts[indptr[i]:indptr[i + 1]]``, two coordinates each.  Returned is whether
    each fit was done; where not, its weights are left as they are.
    """
    counts, (abscissas, ordinates) = np.diff(indptr), charts.T.copy()
    done = np.zeros(len(counts), dtype=np.bool_)
    fits = np.flatnonzero((fewest(degree) <= counts) & (counts <= MAX_POINTS))
    for first in range(0, len(fits), SIDE_BY_SIDE):
        mine = fits[first : first + SIDE_BY_SIDE]
        k = np.arange(counts[mine].max())[:, None]
        there = k < counts[mine]
        at = indptr[mine] + k * there  # columns are filled up with their first point, without weight
        x, y = abscissas.take(at), ordinates.take(at)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            w = there / (NEAR + x * x + y * y)
            sound = weigh(x, y, w, degree)
            w /= w.sum(axis=0)
        done[mine] = sound
        there &= sound
        weights[at[there]] = w[there]
    return done
