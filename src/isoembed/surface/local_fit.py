"""What a vertex adds to its neighbors: a function there minus a polynomial fitted around it without it.

The polynomial is fitted by weighted least squares over a chart, an image of the neighbors in the plane with
the vertex itself at the origin.  Its value there is its constant term, and the neighbors' weights in that
term are what is left of the constant column of the fit when all other monomials are projected out of it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from isoembed.mesh.triangulation import Triangulation

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ENOUGH = 14  # neighbors: four more than a cubic has coefficients
NEAR = 0.5  # square of the distance, in edges, within which weights are even
HUB = 32  # edges: neighbors of a vertex with more of them need not be near each other
SPARE = 3  # neighbors more than coefficients, without which a fit of that degree follows the noise
KEPT = 0.02  # of the square of the constant column: less, and the neighbors' errors are blown up too far
DEPENDENT = 1e-10  # of the square of a column: less is rounding of what the columns before it span


def neighborhoods(triangulation: Triangulation, least: int = ENOUGH) -> tuple[Indices, Indices]:
    """The vertices within two edges of each vertex, or within three where two reach too few.

    Paths do not lead through vertices with more than 32 edges: all neighborhoods together stay within a fixed
    multiple of the triangulation's size.

    Parameters
    ----------
    triangulation : Triangulation
    least : int
        Fewer neighbors than this are extended by a third ring.

    Returns
    -------
    indptr : ndarray of int64, shape (V + 1,)
    indices : ndarray of int64, shape (nnz,)
        The neighbors of vertex i, nearest rings first and i itself not among them, are
        ``indices[indptr[i]:indptr[i + 1]]``.
    """
    adjacency = triangulation.adjacency
    return _rings(adjacency.indptr.astype(np.int64), adjacency.indices.astype(np.int64), least)


def fit_residual_operator(
    neighborhoods: tuple[Indices, Indices], charts: Floats, degree: int = 3
) -> csr_array:
    """``I - fit``: takes values at the vertices to their differences from a fit to the neighbors' values.

    The fit is the polynomial that comes nearest to the neighbors' values with the weights
    ``1 / (1/2 + |p|^2)``, evaluated at the vertex, which has no part in it.  It is of lower degree where
    there are too few neighbors (fewer than 24 for a quintic, 18, 13, 9, 6 for less), or where they lie so
    that a fit of this degree leaves the value at the origin open (all on one side, or on a conic through it).

    Parameters
    ----------
    neighborhoods : (indptr, indices)
        As from the function of this name.
    charts : ndarray, shape (nnz, 2)
        Coordinates p of each neighbor in the plane, with the vertex at the origin, in units of the mean edge
        length about the vertex.

    Returns
    -------
    csr_array, shape (V, V)
        Its rows sum to zero.  It takes cubic polynomials in a chart to zero at the chart's vertex.
    """
    indptr, indices = neighborhoods
    n = len(indptr) - 1
    weights = _fits(indptr, np.ascontiguousarray(charts, dtype=np.float64), degree)
    return csr_array(eye_array(n, format="csr") - csr_array((weights, indices, indptr), shape=(n, n)))


@njit(cache=True)
def _rings(indptr: Indices, indices: Indices, least: int) -> tuple[Indices, Indices]:
    n = len(indptr) - 1
    starts = np.zeros(n + 1, dtype=np.int64)
    seen, reached = np.full(n, -1), np.empty(n, dtype=np.int64)
    for v in range(n):
        starts[v + 1] = starts[v] + _reach(indptr, indices, v, least, seen, reached)
    neighbors = np.empty(starts[n], dtype=np.int64)
    seen[:] = -1
    for v in range(n):
        count = _reach(indptr, indices, v, least, seen, reached)
        neighbors[starts[v] : starts[v + 1]] = reached[:count]
    return starts, neighbors


@njit(cache=True)
def _reach(indptr: Indices, indices: Indices, v: int, least: int, seen: Indices, reached: Indices) -> int:
    """Fill `reached` with the neighbors of v, and count them; `seen` marks them with v."""
    seen[v] = v
    count = 0
    for k in range(indptr[v], indptr[v + 1]):
        reached[count] = indices[k]
        seen[indices[k]] = v
        count += 1
    begin = 0
    for ring in range(2):
        if ring == 1 and count >= least:
            break
        end = count
        for k in range(begin, end):
            u = reached[k]
            if indptr[u + 1] - indptr[u] > HUB:
                continue
            for j in range(indptr[u], indptr[u + 1]):
                w = indices[j]
                if seen[w] != v:
                    seen[w] = v
                    reached[count] = w
                    count += 1
        begin = end
    return count


@njit(cache=True)
def _fits(indptr: Indices, charts: Floats, most: int) -> Floats:
    """The weights of the neighbors in the fitted values, (nnz,)."""
    weights = np.empty(len(charts))
    for v in range(len(indptr) - 1):
        begin, end = indptr[v], indptr[v + 1]
        _constant_term(charts[begin:end], weights[begin:end], most)
    return weights


@njit(cache=True)
def _constant_term(chart: Floats, weights: Floats, most: int) -> None:
    """Fill in the weights by which the constant term of the fit depends on the values at the points."""
    m = len(chart)
    root = np.empty(m)  # of the weights of least squares
    rest = np.empty(m)  # of the constant column
    for k in range(m):
        root[k] = 1.0 / np.sqrt(NEAR + chart[k, 0] ** 2 + chart[k, 1] ** 2)
        rest[k] = root[k]
    whole = _dot(rest, rest)
    best, columns = rest.copy(), np.empty((most * (most + 3) // 2, m))
    count = 0
    for degree in range(1, most + 1):
        if m < (degree + 1) * (degree + 2) // 2 + SPARE:
            break
        for power in range(degree + 1):
            column = columns[count]
            for k in range(m):
                column[k] = root[k] * chart[k, 0] ** (degree - power) * chart[k, 1] ** power
            size = _dot(column, column)
            _project_out(columns[:count], column)
            left = _dot(column, column)
            if left <= DEPENDENT * size:
                continue
            column /= np.sqrt(left)
            _project_out(columns[count : count + 1], rest)
            count += 1
        if not _dot(rest, rest) >= KEPT * whole:
            break
        best[:] = rest
    weights[:] = root * best / _dot(root, best)


@njit(cache=True)
def _project_out(orthonormal: Floats, column: Floats) -> None:
    """Take what lies along orthonormal rows out of a column, twice: once leaves rounding along them."""
    for _ in range(2):
        for row in orthonormal:
            part = _dot(row, column)
            for k in range(len(column)):
                column[k] -= part * row[k]


@njit(cache=True)
def _dot(a: Floats, b: Floats) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total
