"""Batches of local polynomial fits by normal equations.

The fits are those of `local_fit`, which orthogonalizes the columns of each fit in turn.  Here the fits of a
few hundred vertices are vectorized, each step one operation on arrays with an entry per fit: moments of the
weighted points, Cholesky factors of the normal equations, and weights.  The normal equations square the
condition number of a fit; ill-conditioned fits are left to orthogonalization.
"""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.surface.fit_loops import fewest, weigh
from isoembed.threads import run_ranges

NEAR = 0.5  # squared edges: a point p has the weight 1 / (NEAR + |p|^2)
SIDE_BY_SIDE = 128  # fits per batch: their moments stay in the cache
MAX_POINTS = 128  # per fit in a batch
TWO_RINGS = 14  # points: cubics with fewer in two rings use a third (4 more than coefficients)
THREE_RINGS = 30  # points: more than in two rings, so that quintics use a third


def normal_weights(indptr: Indices, charts: Floats, degree: int, weights: Floats) -> Mask:
    """Compute the weights of the points in the constant terms of the well-conditioned fits.

    The points of fit i are ``charts[indptr[i]:indptr[i + 1]]``, two coordinates each.  Returns a mask of the
    computed fits; the weights of the others are unchanged.
    """
    counts, (abscissas, ordinates) = np.diff(indptr), charts.T.copy()
    fitted = np.zeros(len(counts), dtype=np.bool_)
    fits = np.flatnonzero((fewest(degree) <= counts) & (counts <= MAX_POINTS))

    def fit(batch: int) -> None:
        mine = fits[batch * SIDE_BY_SIDE : (batch + 1) * SIDE_BY_SIDE]
        k = np.arange(counts[mine].max())[:, None]
        there = k < counts[mine]
        at = indptr[mine] + k * there  # columns are padded with their first point, with weight zero
        x, y = abscissas.take(at), ordinates.take(at)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            w = there / (NEAR + x * x + y * y)
            sound = weigh(x, y, w, degree)
            w /= w.sum(axis=0)
        fitted[mine] = sound
        there &= sound
        weights[at[there]] = w[there]

    def fit_all(batches: range) -> None:
        for batch in batches:
            fit(batch)

    run_ranges(fit_all, -(-len(fits) // SIDE_BY_SIDE), 4)
    return fitted
