"""Many polynomial fits at a time, by their normal equations, where these are well conditioned.

The fits are those of `local_fit`, which orthogonalizes the columns of one fit after the other.  Here the fits
of a few hundred vertices go through the same steps side by side, so that each step is one loop over them: the
moments of their weighted points, Cholesky's factors of the normal equations, and the weights.  The normal
equations square the condition of a fit; a fit that they might spoil is left to the other way.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.kernel import kernel
from isoembed.thresholds import compiled, threshold


@dataclass(frozen=True)
class FitThresholds:
    """Thresholds of the polynomials that are fitted to the neighbors of a vertex."""

    near: float = threshold(0.5, "squared edges", "A point p has the weight 1 / (near + |p|^2).")
    spare: int = threshold(3, "points", "More than coefficients: with fewer a fit follows the noise.")
    kept: float = threshold(
        0.02, "relative", "Left of the squared constant column; less, and the neighbors' errors are blown up."
    )
    dependent: float = threshold(1e-10, "relative", "Left of a squared column; less is rounding.")
    independent: float = threshold(
        1e-3, "relative", "Left of a squared column; less, and normal equations lose more than three digits."
    )
    side_by_side: int = threshold(128, "fits", "Made at a time: their moments stay in a cache.")
    most: int = threshold(128, "points", "Of fits that are made side by side.")
    two_rings: int = threshold(14, "points", "Fewer in two rings, and a cubic gets a third: 4 to spare.")
    three_rings: int = threshold(30, "points", "More than two rings have: a quintic gets a third.")
    hub: int = threshold(32, "edges", "Neighbors of a vertex with more need not be near each other.")
    at_once: int = threshold(1 << 16, "vertices", "Whose fits are made together: their charts take memory.")
    robust: float = threshold(2 / 3, "exponent", "Of the mean of what quintics leave.")
    plain: float = threshold(0.2, "relative", "Of the angles around; less, and an error may decide the sign.")


FITS = FitThresholds()
_T = compiled(FITS)


@kernel
def fewest(degree: int) -> int:
    """Points without which a fit of this degree is not wanted."""
    return (degree + 1) * (degree + 2) // 2 + _T.spare


@kernel
def normal_weights(indptr: Indices, charts: Floats, degree: int, weights: Floats) -> Mask:
    """Fill in the weights of the points in the constant terms of the fits, where that can be done safely.

    The points of fit i are ``charts[indptr[i]:indptr[i + 1]]``, two coordinates each.  Returned is whether
    each fit was done; where not, its weights are to be ignored.
    """
    n = len(indptr) - 1
    columns = degree * (degree + 3) // 2
    shape = (_T.most, _T.side_by_side)
    x, y, w = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    moments = np.empty(((degree + 1) * (2 * degree + 1), _T.side_by_side))
    powers, terms = np.empty_like(moments), np.empty((columns, _T.side_by_side))
    factor = np.empty((columns + 1, columns + 1, _T.side_by_side))
    inverses, rest = np.empty((columns, _T.side_by_side)), np.empty(_T.side_by_side)
    done, sound = np.zeros(n, dtype=np.bool_), np.empty(_T.side_by_side, dtype=np.bool_)
    for first in range(0, n, _T.side_by_side):
        last = min(first + _T.side_by_side, n)
        rows = _spread(indptr, charts, first, last, fewest(degree), x, y, w)
        _set_moments(x[:rows], y[:rows], w[:rows], degree, powers, moments)
        _factorize(moments, degree, factor, inverses, rest, sound)
        _solve(factor, inverses, terms)
        _evaluate(x[:rows], y[:rows], w[:rows], degree, terms, powers)
        for i in range(first, last):
            lane = i - first
            done[i] = sound[lane] and rest[lane] >= _T.kept * moments[0, lane]
            if done[i]:
                total = 0.0
                for k in range(indptr[i + 1] - indptr[i]):
                    total += w[k, lane]
                for k in range(indptr[i + 1] - indptr[i]):
                    weights[indptr[i] + k] = w[k, lane] / total
    return done


@kernel
def _spread(
    indptr: Indices, charts: Floats, first: int, last: int, fewest: int, x: Floats, y: Floats, w: Floats
) -> int:
    """Put the points of each fit into a column, filled up with points without weight; return the rows."""
    rows = 0
    for i in range(first, last):
        count = indptr[i + 1] - indptr[i]
        if fewest <= count <= _T.most:
            rows = max(rows, count)
    for k in range(rows):
        for lane in range(_T.side_by_side):
            x[k, lane], y[k, lane], w[k, lane] = 0.0, 0.0, 0.0
    for i in range(first, last):
        count = indptr[i + 1] - indptr[i]
        if fewest <= count <= _T.most:
            for k in range(count):
                p, q = charts[indptr[i] + k, 0], charts[indptr[i] + k, 1]
                x[k, i - first], y[k, i - first], w[k, i - first] = p, q, 1.0 / (_T.near + p * p + q * q)
    return rows


@kernel
def _set_moments(x: Floats, y: Floats, w: Floats, degree: int, powers: Floats, moments: Floats) -> None:
    """Sum w x^(d - p) y^p over the points, at d (d + 1) / 2 + p for d up to twice the degree."""
    for at in range(len(moments)):
        moment = moments[at]
        for lane in range(_T.side_by_side):
            moment[lane] = 0.0
    for k in range(len(x)):
        _multiply(w[k], x[k], y[k], 2 * degree, powers)
        for at in range(len(moments)):
            moment, power = moments[at], powers[at]
            for lane in range(_T.side_by_side):
                moment[lane] += power[lane]


@kernel
def _copy(source: Floats, target: Floats) -> None:
    for lane in range(_T.side_by_side):
        target[lane] = source[lane]


@kernel
def _multiply(first: Floats, x: Floats, y: Floats, degree: int, powers: Floats) -> None:
    """Fill in x^(d - p) y^p times the first of them."""
    _copy(first, powers[0])
    at = 1
    for d in range(1, degree + 1):
        for p in range(d + 1):
            lower, power, factor = powers[at - d - p // d], powers[at], y if p == d else x
            for lane in range(_T.side_by_side):
                power[lane] = lower[lane] * factor[lane]
            at += 1


@kernel
def _factorize(
    moments: Floats, degree: int, factor: Floats, inverses: Floats, rest: Floats, sound: Mask
) -> None:
    """Factorize the matrices of the monomials' products; the constant comes last, and `rest` is its pivot."""
    columns = len(inverses)
    of_degree, of_power = np.empty(columns + 1, dtype=np.int64), np.empty(columns + 1, dtype=np.int64)
    column = 0
    for d in range(1, degree + 1):
        for p in range(d + 1):
            of_degree[column], of_power[column] = d, p
            column += 1
    of_degree[columns], of_power[columns] = 0, 0
    for lane in range(_T.side_by_side):
        sound[lane], rest[lane] = True, moments[0, lane]
    for j in range(columns):
        inverse = inverses[j]
        for i in range(j, columns + 1):
            d = of_degree[i] + of_degree[j]
            product, entry = moments[d * (d + 1) // 2 + of_power[i] + of_power[j]], factor[i, j]
            _copy(product, entry)
            for k in range(j):
                left, right = factor[i, k], factor[j, k]
                for lane in range(_T.side_by_side):
                    entry[lane] -= left[lane] * right[lane]
            if i == j:
                for lane in range(_T.side_by_side):
                    good = entry[lane] > _T.independent * product[lane]
                    sound[lane] &= good
                    inverse[lane] = 1.0 / np.sqrt(entry[lane]) if good else 0.0
            for lane in range(_T.side_by_side):
                entry[lane] *= inverse[lane]
        last = factor[columns, j]
        for lane in range(_T.side_by_side):
            rest[lane] -= last[lane] * last[lane]


@kernel
def _solve(factor: Floats, inverses: Floats, terms: Floats) -> None:
    """The coefficients of the monomials in the constant's own fit."""
    columns = len(inverses)
    for j in range(columns - 1, -1, -1):
        term, inverse = terms[j], inverses[j]
        _copy(factor[columns, j], term)
        for i in range(j + 1, columns):
            entry, other = factor[i, j], terms[i]
            for lane in range(_T.side_by_side):
                term[lane] -= entry[lane] * other[lane]
        for lane in range(_T.side_by_side):
            term[lane] *= inverse[lane]


@kernel
def _evaluate(x: Floats, y: Floats, w: Floats, degree: int, terms: Floats, powers: Floats) -> None:
    """Multiply the points' weights by what their fit leaves of the constant."""
    ones = np.ones(_T.side_by_side)
    left = np.empty(_T.side_by_side)
    for k in range(len(x)):
        _multiply(ones, x[k], y[k], degree, powers)
        _copy(ones, left)
        for j in range(len(terms)):
            term, power = terms[j], powers[j + 1]
            for lane in range(_T.side_by_side):
                left[lane] -= term[lane] * power[lane]
        weight = w[k]
        for lane in range(_T.side_by_side):
            weight[lane] *= left[lane]
