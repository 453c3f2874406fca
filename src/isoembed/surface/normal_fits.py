"""Many polynomial fits at a time, by their normal equations, where these are well conditioned.

The fits are those of `local_fit`, which orthogonalizes the columns of one fit after the other.  Here the fits
of a few hundred vertices go through the same steps side by side, so that each step is one operation on rows
of numbers, a number a fit (`isoembed.surface.rows`): the moments of their weighted points, Cholesky's factors
of the normal equations, and the weights.  The normal equations square the condition of a fit; a fit that they
might spoil is left to the other way.
"""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.kernel import kernel
from isoembed.surface.rows import add, copy, invert_root, multiply, subtract_product

NEAR = 0.5  # squared edges: a point p has the weight 1 / (NEAR + |p|^2)
SPARE_POINTS = 3  # beyond the coefficients: with fewer a fit follows the noise
KEPT = 0.02  # of the squared constant column: with less left, the neighbors' errors are blown up
SIDE_BY_SIDE = 128  # fits made at a time: their moments stay in a cache
MAX_POINTS = 128  # of fits that are made side by side
TWO_RINGS = 14  # points: fewer in two rings, and a cubic gets a third: 4 to spare
THREE_RINGS = 30  # points: more than two rings have, so that a quintic gets a third


@kernel
def fewest(degree: int) -> int:
    """Points without which a fit of this degree is not wanted."""
    return (degree + 1) * (degree + 2) // 2 + SPARE_POINTS


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
            sound = _weigh(x, y, w, degree)
            w /= w.sum(axis=0)
        done[mine] = sound
        there &= sound
        weights[at[there]] = w[there]
    return done


@kernel
def _weigh(x: Floats, y: Floats, w: Floats, degree: int) -> Mask:
    """Multiply the weights of points by what their fits, one a column, leave of the constant: which can."""
    columns, lanes = degree * (degree + 3) // 2, x.shape[1]
    moments = np.zeros(((degree + 1) * (2 * degree + 1), lanes))
    factor, terms = np.empty((columns + 1, columns + 1, lanes)), np.empty((columns, lanes))
    rest, sound = np.empty(lanes), np.ones(lanes, dtype=np.bool_)
    _add_moments(x, y, w, degree, moments)
    _factorize(moments, degree, factor, rest, sound)
    _solve(factor, terms)
    _evaluate(x, y, w, degree, terms)
    for lane in range(lanes):
        sound[lane] &= rest[lane] >= KEPT * moments[0, lane]
    return sound


@kernel
def _multiply(first: Floats, x: Floats, y: Floats, degree: int, powers: Floats) -> None:
    """Fill in x^(d - p) y^p times the first of them, at d (d + 1) / 2 + p."""
    copy(first, powers[0])
    at = 1
    for d in range(1, degree + 1):
        for _ in range(d):
            multiply(powers[at - d], x, powers[at])
            at += 1
        multiply(powers[at - d - 1], y, powers[at])
        at += 1


@kernel
def _add_moments(x: Floats, y: Floats, w: Floats, degree: int, moments: Floats) -> None:
    """Sum w x^(d - p) y^p over the points, at d (d + 1) / 2 + p for d up to twice the degree."""
    powers = np.empty_like(moments)
    for k in range(len(x)):
        _multiply(w[k], x[k], y[k], 2 * degree, powers)
        for at in range(len(moments)):
            add(powers[at], moments[at])


@kernel
def _factorize(moments: Floats, degree: int, factor: Floats, rest: Floats, sound: Mask) -> None:
    """Factorize the matrices of the monomials' products; the constant comes last, and `rest` is its pivot.

    In the place of its diagonal is its inverse.
    """
    columns = len(factor) - 1
    of_degree, of_power = np.zeros(columns + 1, dtype=np.int64), np.zeros(columns + 1, dtype=np.int64)
    column = 0
    for d in range(1, degree + 1):
        for p in range(d + 1):
            of_degree[column], of_power[column] = d, p
            column += 1
    copy(moments[0], rest)
    for j in range(columns):
        inverse = factor[j, j]
        for i in range(columns, j - 1, -1):
            d = of_degree[i] + of_degree[j]
            product, entry = moments[d * (d + 1) // 2 + of_power[i] + of_power[j]], factor[i, j]
            copy(product, entry)
            for k in range(j):
                subtract_product(factor[i, k], factor[j, k], entry)
            if i == j:
                # with less left of a column, normal equations lose more than three digits
                invert_root(product, 1e-3, inverse, sound)
        for i in range(j + 1, columns + 1):
            multiply(factor[i, j], inverse, factor[i, j])
        subtract_product(factor[columns, j], factor[columns, j], rest)


@kernel
def _solve(factor: Floats, terms: Floats) -> None:
    """The coefficients of the monomials in the constant's own fit."""
    columns = len(terms)
    for j in range(columns - 1, -1, -1):
        copy(factor[columns, j], terms[j])
        for i in range(j + 1, columns):
            subtract_product(factor[i, j], terms[i], terms[j])
        multiply(terms[j], factor[j, j], terms[j])


@kernel
def _evaluate(x: Floats, y: Floats, w: Floats, degree: int, terms: Floats) -> None:
    """Multiply the points' weights by what their fit leaves of the constant."""
    powers = np.empty((len(terms) + 1, x.shape[1]))
    for k in range(len(x)):
        _multiply(w[k], x[k], y[k], degree, powers)
        for j in range(len(terms)):
            subtract_product(terms[j], powers[j + 1], w[k])
