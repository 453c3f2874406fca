# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled local polynomial fits."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstInt32, ConstReal, Flag, Int, Int32, Real
from cython.cimports.libc.math import sqrt

NEAR = cython.declare(cython.double, 0.5)  # as in `normal_fits`
SPARE_POINTS = cython.declare(
    cython.longlong, 3
)  # beyond the number of coefficients: with fewer, a fit follows the noise
KEPT = cython.declare(
    cython.double, 0.02
)  # remaining fraction of the squared constant column: with less, the neighbors' errors are amplified
HUB_DEGREE = cython.declare(cython.longlong, 32)  # as in `local_fit`


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def copy(A: ConstReal[:, ::1], i: Int, B: Real[:, ::1], k: Int) -> cython.void:
    """Copy row i of A to row k of B."""
    for lane in range(B.shape[1]):
        B[k, lane] = A[i, lane]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def multiply(
    A: ConstReal[:, ::1], i: Int, B: ConstReal[:, ::1], j: Int, C: Real[:, ::1], k: Int
) -> cython.void:
    """Store the elementwise product of two rows."""
    for lane in range(C.shape[1]):
        C[k, lane] = A[i, lane] * B[j, lane]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def subtract_product(
    A: ConstReal[:, ::1], i: Int, B: ConstReal[:, ::1], j: Int, C: Real[:, ::1], k: Int
) -> cython.void:
    """Subtract the elementwise product of two rows from a third."""
    for lane in range(C.shape[1]):
        C[k, lane] -= A[i, lane] * B[j, lane]


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def subtract_multiple(
    factor: Real, A: ConstReal[:, ::1], i: Int, C: Real[:, ::1], k: Int, first: Int, last: Int
) -> cython.void:
    """Subtract a multiple of part of a row from the same part of another."""
    for lane in range(first, last):
        C[k, lane] -= factor * A[i, lane]


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def dot(A: ConstReal[:, ::1], i: Int, B: ConstReal[:, ::1], j: Int, first: Int, last: Int) -> Real:
    """Dot product of parts of two rows, summed in order."""
    total: Real = 0.0
    for lane in range(first, last):
        total += A[i, lane] * B[j, lane]
    return total


@cython.ccall
@cython.exceptval(check=False)
def fewest(degree: Int) -> Int:
    """Minimum number of points for a fit of this degree."""
    return (degree + 1) * (degree + 2) // 2 + SPARE_POINTS


def weigh(x: ConstReal[:, ::1], y: ConstReal[:, ::1], w: Real[:, ::1], degree: Int):
    """Multiply the weights of points by the constant orthogonalized in their fits; return which succeeded.

    There is one fit per column; the fits are vectorized, one lane each.
    """
    columns, lanes = degree * (degree + 3) // 2, x.shape[1]
    moments: Real[:, ::1] = np.zeros(((degree + 1) * (2 * degree + 1), lanes))
    powers: Real[:, ::1] = np.empty(((degree + 1) * (2 * degree + 1), lanes))
    factor: Real[:, ::1] = np.empty(((columns + 1) * (columns + 1), lanes))
    terms: Real[:, ::1] = np.empty((columns, lanes))
    rest: Real[:, ::1] = np.empty((1, lanes))
    sound: Flag[::1] = np.ones(lanes, dtype=np.bool_)
    shapes: Int[:, ::1] = np.zeros((2, columns + 1), dtype=np.int64)
    with cython.nogil:
        _add_moments(x, y, w, degree, moments, powers)
        _factorize(moments, degree, factor, rest, sound, shapes)
        _solve(factor, terms)
        _evaluate(x, y, w, degree, terms, powers)
        for lane in range(lanes):
            sound[lane] &= rest[0, lane] >= KEPT * moments[0, lane]
    return np.asarray(sound)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _multiply_out(
    x: ConstReal[:, ::1], y: ConstReal[:, ::1], w: Real[:, ::1], k: Int, degree: Int, powers: Real[:, ::1]
) -> cython.void:
    """Fill in w x^(d - p) y^p of point k, at d (d + 1) / 2 + p."""
    copy(w, k, powers, 0)
    at: Int = 1
    for d in range(1, degree + 1):
        for _ in range(d):
            multiply(powers, at - d, x, k, powers, at)
            at += 1
        multiply(powers, at - d - 1, y, k, powers, at)
        at += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _add_moments(
    x: ConstReal[:, ::1],
    y: ConstReal[:, ::1],
    w: Real[:, ::1],
    degree: Int,
    moments: Real[:, ::1],
    powers: Real[:, ::1],
) -> cython.void:
    """Sum w x^(d - p) y^p over the points, at d (d + 1) / 2 + p for d up to twice the degree."""
    for k in range(x.shape[0]):
        _multiply_out(x, y, w, k, 2 * degree, powers)
        for at in range(moments.shape[0]):
            for lane in range(moments.shape[1]):
                moments[at, lane] += powers[at, lane]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _factorize(
    moments: Real[:, ::1],
    degree: Int,
    factor: Real[:, ::1],
    rest: Real[:, ::1],
    sound: Flag[::1],
    shapes: Int[:, ::1],
) -> cython.void:
    """Cholesky factorization of the Gram matrices of the monomials; the constant is last, with pivot `rest`.

    The diagonal of the factor is stored inverted.
    """
    columns = degree * (degree + 3) // 2
    n = columns + 1
    column: Int = 0
    for d in range(1, degree + 1):
        for p in range(d + 1):
            shapes[0, column], shapes[1, column] = d, p
            column += 1
    copy(moments, 0, rest, 0)
    for j in range(columns):
        for i in range(columns, j - 1, -1):
            both = shapes[0, i] + shapes[0, j]
            at = both * (both + 1) // 2 + shapes[1, i] + shapes[1, j]
            entry = i * n + j
            copy(moments, at, factor, entry)
            for k in range(j):
                subtract_product(factor, i * n + k, factor, j * n + k, factor, entry)
            if i == j:
                # with smaller pivots, normal equations lose more than three digits
                for lane in range(factor.shape[1]):
                    good: cython.bint = factor[entry, lane] > 1e-3 * moments[at, lane]
                    sound[lane] &= good
                    factor[entry, lane] = 1.0 / sqrt(factor[entry, lane]) if good else 0.0
        for i in range(j + 1, n):
            multiply(factor, i * n + j, factor, j * n + j, factor, i * n + j)
        subtract_product(factor, columns * n + j, factor, columns * n + j, rest, 0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _solve(factor: Real[:, ::1], terms: Real[:, ::1]) -> cython.void:
    """Coefficients of the monomials in the fit of the constant."""
    columns = terms.shape[0]
    n = columns + 1
    for j in range(columns - 1, -1, -1):
        copy(factor, columns * n + j, terms, j)
        for i in range(j + 1, columns):
            subtract_product(factor, i * n + j, terms, i, terms, j)
        multiply(terms, j, factor, j * n + j, terms, j)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _evaluate(
    x: ConstReal[:, ::1],
    y: ConstReal[:, ::1],
    w: Real[:, ::1],
    degree: Int,
    terms: Real[:, ::1],
    powers: Real[:, ::1],
) -> cython.void:
    """Multiply the points' weights by the residual of the fit of the constant."""
    for k in range(x.shape[0]):
        _multiply_out(x, y, w, k, degree, powers)
        for j in range(terms.shape[0]):
            subtract_product(terms, j, powers, j + 1, w, k)


def rings(indptr: ConstInt32[::1], indices: ConstInt32[::1], least: Int, first: Int, last: Int):
    """Neighborhoods of the vertices in the half-open range from `first` to `last`, as `neighborhoods`."""
    n = indptr.shape[0] - 1
    starts: Int[::1] = np.zeros(last - first + 1, dtype=np.int64)
    neighbors: Int32[::1] = np.empty(3 * least * (last - first), dtype=np.int32)
    reached: Int32[::1] = np.empty(n, dtype=np.int32)
    visited: Int32[::1] = np.full(n, -1, dtype=np.int32)
    for v in range(first, last):
        begin = starts[v - first]
        count = _reach(indptr, indices, v, least, visited, reached)
        if begin + count > neighbors.shape[0]:
            longer: Int32[::1] = np.empty(2 * (begin + count), dtype=np.int32)
            for k in range(begin):
                longer[k] = neighbors[k]
            neighbors = longer
        for k in range(count):
            neighbors[begin + k] = reached[k]
        starts[v - first + 1] = begin + count
    return np.asarray(starts), np.array(neighbors[: starts[last - first]])


@cython.cfunc
@cython.exceptval(check=False)
def _reach(
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    v: Int,
    least: Int,
    visited: Int32[::1],
    reached: Int32[::1],
) -> Int:
    """Fill `reached` with the neighbors of v, and count them; `visited` marks them with v."""
    visited[v] = v
    count: Int = 0
    for k in range(indptr[v], indptr[v + 1]):
        reached[count] = indices[k]
        visited[indices[k]] = v
        count += 1
    begin: Int = 0
    for ring in range(2):
        if ring == 1 and count >= least:
            break
        end = count
        for k in range(begin, end):
            u = reached[k]
            if indptr[u + 1] - indptr[u] > HUB_DEGREE:
                continue
            for j in range(indptr[u], indptr[u + 1]):
                w = indices[j]
                reached[count] = w  # overwritten by the next one unless new
                count += visited[w] != v
                visited[w] = v
        begin = end
    return count


def fit_constants(
    vertices: ConstInt[::1], indptr: ConstInt[::1], charts: ConstReal[:, ::1], most: Int, weights: Real[::1]
):
    """Compute the weights of the neighbors of some vertices, one vertex after the other.

    They are the derivatives of the constant term of the fit with respect to the values at the points.
    """
    for i in vertices:
        _fit_constant(charts, indptr[i], indptr[i + 1], most, weights)


@cython.cfunc
def _fit_constant(charts: ConstReal[:, ::1], begin: Int, end: Int, most: Int, weights: Real[::1]) -> object:
    m, spare = end - begin, most * (most + 3) // 2
    rows: Real[:, ::1] = np.empty((spare + 3, m))
    root, rest, best = spare, spare + 1, spare + 2  # root of the weights; residuals of the constant column
    for k in range(m):
        x, y = charts[begin + k, 0], charts[begin + k, 1]
        rows[root, k] = 1.0 / sqrt(NEAR + x * x + y * y)
    copy(rows, root, rows, rest)
    copy(rows, rest, rows, best)
    whole = dot(rows, rest, rows, rest, 0, m)
    column: Int = 0
    for degree in range(1, most + 1):
        if m < fewest(degree):
            break
        for power in range(degree + 1):
            copy(rows, root, rows, column)
            for factor in range(degree):
                axis: Int = 1 if factor < power else 0
                for k in range(m):
                    rows[column, k] *= charts[begin + k, axis]
            size = dot(rows, column, rows, column, 0, m)
            _project_out(rows, 0, column, column)
            left = dot(rows, column, rows, column, 0, m)
            if left <= 1e-10 * size:  # the remaining squared column is rounding error
                continue
            left = sqrt(left)
            for k in range(m):
                rows[column, k] /= left
            _project_out(rows, column, column + 1, rest)
            column += 1
        if not dot(rows, rest, rows, rest, 0, m) >= KEPT * whole:
            break
        copy(rows, rest, rows, best)
    scale = dot(rows, root, rows, best, 0, m)
    for k in range(m):
        weights[begin + k] = rows[root, k] * rows[best, k] / scale
    return None


@cython.cfunc
@cython.exceptval(check=False)
def _project_out(rows: Real[:, ::1], first: Int, last: Int, column: Int) -> cython.void:
    """Orthogonalize a row against orthonormal ones, twice: once leaves rounding error along them."""
    for _ in range(2):
        for row in range(first, last):
            subtract_multiple(
                dot(rows, row, rows, column, 0, rows.shape[1]), rows, row, rows, column, 0, rows.shape[1]
            )


@cython.cfunc
@cython.exceptval(check=False)
def _set_seen(
    v: Int, w: Int, points: ConstReal[:, ::1], heights: ConstReal[::1], curvature: Real, seen: Real[::1]
) -> cython.void:
    """Set the coordinates returned by `seen_from`."""
    if curvature == 0:
        for k in range(3):
            seen[k] = points[w, k] - points[v, k]
        return
    product: Real = 0.0
    for k in range(3):
        product += points[v, k] * points[w, k]
    along = heights[w] + curvature * product / (1.0 + heights[v])
    height = heights[v] * heights[w] + curvature * product
    scale = 2.0 / (1.0 + height)
    for k in range(3):
        seen[k] = (points[w, k] - along * points[v, k]) * scale


def seen_from(v: Int, w: Int, points: ConstReal[:, ::1], heights: ConstReal[::1], curvature: Real):
    """Conformal coordinates (3,) of point w about point v, given points (V, 3) and their `Space.heights`."""
    seen: Real[::1] = np.empty(3)
    _set_seen(v, w, points, heights, curvature, seen)
    return np.asarray(seen)


def fit_tensors(
    first: Int,
    indptr: ConstInt[::1],
    indices: ConstInt32[::1],
    surface: object,
    values: ConstReal[:, ::1],
    degree: Int,
    operators: Real[:, :, ::1],
    hessians: Real[:, :, :, ::1],
):
    """Compute the tensors of the vertices from `first` on; they stay zero where no quadric can be fitted."""
    points: ConstReal[:, ::1] = surface.vertices
    normals: ConstReal[:, ::1] = surface.normals
    spacing: ConstReal[::1] = surface.units
    heights: ConstReal[::1] = surface.heights
    curvature: Real = surface.curvature
    most: Int = 1
    for i in range(indptr.shape[0] - 1):
        most = max(most, indptr[i + 1] - indptr[i] + 1)
    size, right = (degree + 1) * (degree + 2) // 2, 1 + values.shape[1]
    chart: Real[:, ::1] = np.empty((most, 3))
    system: Real[:, ::1] = np.empty((size + right, most))
    known: Real[:, ::1] = np.empty((most, right))
    tensors: Real[:, :, ::1] = np.empty((right, 3, 3))
    frame: Real[:, ::1] = np.empty((3, 3))  # two tangents and the normal
    dual: Real[:, ::1] = np.empty((2, 3))
    seen: Real[::1] = np.empty(3)
    count: Int
    for i in range(indptr.shape[0] - 1):
        v = first + i
        for c in range(3):
            frame[2, c] = normals[v, c]
        _complete(frame)
        for c in range(3):
            chart[0, c] = 0.0
        for j in range(right - 1):
            known[0, j] = 0.0
        count = 1
        for k in range(indptr[i], indptr[i + 1]):
            w = indices[k]
            # with normals that turn more, the neighbor is around a bend
            if dot(normals, w, normals, v, 0, 3) < 0.3:
                continue
            _set_seen(v, w, points, heights, curvature, seen)
            for c in range(3):
                seen[c] = seen[c] / spacing[v]
            for c in range(3):
                chart[count, c] = seen[0] * frame[c, 0] + seen[1] * frame[c, 1] + seen[2] * frame[c, 2]
            for j in range(right - 1):
                known[count, j] = values[w, j] - values[v, j]
            count += 1
        for lower in range(degree, 1, -1):
            needed = (lower + 1) * (lower + 2) // 2
            if count >= fewest(lower) and _solved(chart, known, right - 1, count, lower, system):
                _set_tensors(system, needed, frame, dual, tensors)
                for a in range(3):
                    for b in range(3):
                        operators[v, a, b] = -tensors[0, a, b] / spacing[v]
                        for j in range(1, right):
                            hessians[v, j - 1, a, b] = tensors[j, a, b] / (spacing[v] * spacing[v])
                break


@cython.cfunc
@cython.exceptval(check=False)
def _complete(frame: Real[:, ::1]) -> cython.void:
    """Complete a unit vector, the last row, to a right-handed frame."""
    least: Int = 0
    for c in range(1, 3):
        if abs(frame[2, c]) < abs(frame[2, least]):
            least = c
    for c in range(3):
        frame[0, c] = -frame[2, least] * frame[2, c]
    frame[0, least] += 1.0
    size = sqrt(dot(frame, 0, frame, 0, 0, 3))
    for c in range(3):
        frame[0, c] /= size
    for c in range(3):
        a, b = (c + 1) % 3, (c + 2) % 3
        frame[1, c] = frame[2, a] * frame[0, b] - frame[2, b] * frame[0, a]


@cython.cfunc
@cython.exceptval(check=False)
def _solved(
    chart: Real[:, ::1], known: Real[:, ::1], functions: Int, m: Int, degree: Int, system: Real[:, ::1]
) -> cython.bint:
    """Fit heights and values at m points by Householder reflections.

    The coefficients replace the right-hand sides.  The rows of `system` are first the columns of the
    monomials, then the heights and the values; monomials are ordered by degree, and within a degree by the
    power of the second coordinate.
    """
    size = (degree + 1) * (degree + 2) // 2
    rows = size + 1 + functions
    at: Int
    for k in range(m):
        p, q = chart[k, 0], chart[k, 1]
        root = 1.0 / sqrt(NEAR + p * p + q * q)
        system[0, k] = root
        at = 1
        for d in range(1, degree + 1):
            for power in range(d):
                system[at + power, k] = system[at + power - d, k] * p
            system[at + d, k] = system[at - 1, k] * q
            at += d + 1
        system[size, k] = root * chart[k, 2]
        for j in range(functions):
            system[size + 1 + j, k] = root * known[k, j]
    for c in range(size):
        whole, left = dot(system, c, system, c, 0, m), dot(system, c, system, c, c, m)
        if left <= 1e-6 * 1e-6 * whole:  # the fit is undetermined
            return False
        diagonal = -sqrt(left) if system[c, c] > 0 else sqrt(left)
        system[c, c] -= diagonal
        scale = -1.0 / (diagonal * system[c, c])
        for r in range(c + 1, rows):
            part = scale * dot(system, c, system, r, c, m)
            subtract_multiple(part, system, c, system, r, c, m)
        system[c, c] = diagonal  # the reflection has been applied
    for r in range(size, rows):
        for c in range(size - 1, -1, -1):
            for j in range(c + 1, size):
                system[r, c] -= system[j, c] * system[r, j]
            system[r, c] /= system[c, c]
    return True


@cython.cfunc
@cython.exceptval(check=False)
def _set_tensors(
    system: Real[:, ::1], row: Int, frame: Real[:, ::1], dual: Real[:, ::1], tensors: Real[:, :, ::1]
) -> cython.void:
    """Compute the surface's second derivatives along its normal, then the Hessians of the functions.

    With z the height, the metric of the graph is ``g = 1 + dz dz``; the normal component of its second
    derivatives is ``z_ij / W``, ``W^2 = 1 + |dz|^2``, and the Hessian of f is ``f_ij - z_ij (dz . df) /
    W^2``.  Their coefficients are in `row` and the following rows of the system.
    """
    p, q = system[row, 1], system[row, 2]
    square = 1.0 + p * p + q * q
    # The dual basis of the tangent vectors (1, 0, p) and (0, 1, q).
    for c in range(3):
        x, y = frame[0, c] + p * frame[2, c], frame[1, c] + q * frame[2, c]
        dual[0, c] = ((1.0 + q * q) * x - p * q * y) / square
        dual[1, c] = ((1.0 + p * p) * y - p * q * x) / square
    for j in range(tensors.shape[0]):
        f = row + j
        factor = 1.0 / sqrt(square) if j == 0 else 1.0
        slope = 0.0 if j == 0 else (p * system[f, 1] + q * system[f, 2]) / square
        xx = 2.0 * (factor * system[f, 3] - slope * system[row, 3])
        xy = factor * system[f, 4] - slope * system[row, 4]
        yy = 2.0 * (factor * system[f, 5] - slope * system[row, 5])
        for a in range(3):
            for b in range(3):
                mixed = dual[0, a] * dual[1, b] + dual[1, a] * dual[0, b]
                tensors[j, a, b] = xx * dual[0, a] * dual[0, b] + xy * mixed + yy * dual[1, a] * dual[1, b]
