"""Second derivatives at the vertices: the surface's shape operator, and the Hessians of functions on it.

About each vertex the surface is the graph of a polynomial over the plane across the vertex's normal, fitted
by weighted least squares to the vertices within three edges; functions are fitted over the same plane.
Quartics leave errors of third order in the edge length, and of fourth where the neighbors lie evenly; cubics
of second.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.kernel import kernel
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface.local_fit import Graph, Surroundings
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.normal_fits import NEAR, fewest
from isoembed.surface.rows import dot, subtract_multiple
from isoembed.surface.tangent_frames import directions, seen_from


def shape_operators(
    triangulation: Triangulation, vertices: Floats, degree: int = 4, space: Space = EUCLIDEAN
) -> Floats:
    """Shape operators at the vertices, as symmetric tensors in R^3.

    Parameters
    ----------
    triangulation : Triangulation
        Oriented so that its normals point outward; inward, all signs change.
    vertices : ndarray, shape (V, 3)
    degree : int
        Of the polynomials; lower at vertices that have too few neighbors for it.
    space : Space
        In which the vertices are.  The tensors are in the frames of `isoembed.surface.tangent_frames`.

    Returns
    -------
    ndarray, shape (V, 3, 3)
        B, in the unit of length to the power -1: ``B n = 0``, and ``t . B t`` is the normal curvature along
        a unit tangent vector t, positive where the surface is convex.
    """
    nothing = np.empty((len(vertices), 0))
    return second_derivatives(triangulation, vertices, nothing, degree, space)[0]


def second_derivatives(
    triangulation: Triangulation,
    vertices: Floats,
    values: Floats,
    degree: int = 4,
    space: Space = EUCLIDEAN,
) -> tuple[Floats, Floats]:
    """Shape operators, and the covariant Hessians of functions that are given at the vertices.

    Parameters
    ----------
    triangulation, vertices, degree, space
        As in `shape_operators`.
    values : ndarray, shape (V, m)

    Returns
    -------
    operators : ndarray, shape (V, 3, 3)
    hessians : ndarray, shape (V, m, 3, 3)
        Symmetric tensors in R^3 that take nothing from the normal: ``t . h t`` is the second derivative along
        the geodesic that starts along the unit tangent vector t.
    """
    n = triangulation.n_vertices
    unit = edge_lengths(triangulation.edges, vertices).mean()
    origin = vertices.mean(axis=0) if space.is_euclidean else np.zeros(3)  # to move it would turn the frames
    surface = Surroundings.of(triangulation, (vertices - origin) / unit, space.scaled(1 / unit))
    operators, hessians = np.zeros((n, 3, 3)), np.zeros((n, values.shape[1], 3, 3))
    columns = np.ascontiguousarray(values, dtype=np.float64)
    # points: more than two rings hold, but where degrees are high; the chunks bound the memory
    for first, near in surface.neighborhoods(60, 10_000):
        _fit(first, near, surface, columns, degree, operators, hessians)
    return operators / unit, hessians / unit / unit


def normal_curvatures(
    triangulation: Triangulation, vertices: Floats, operators: Floats, space: Space = EUCLIDEAN
) -> Floats:
    """Normal curvatures of the surface along the edges, (E,): the mean of those at the two ends.

    From the `shape_operators`; with Hessians in their place, these are a function's second derivatives.
    """
    ends = triangulation.edges.T
    normals = vertex_normals(triangulation.faces, to_model(space, vertices, "conformal"))
    curvatures = np.zeros(triangulation.n_edges)
    for here, there in (ends, ends[::-1]):
        # An edge leaves the tangent plane by half the angle that it spans; along the surface it is shorter.
        along = directions(space, vertices[here], vertices[there])
        rise = np.einsum("ei,ei->e", along, normals[here])
        form = np.einsum("ei,eij,ej->e", along, operators[here], along)
        curvatures += form / np.maximum(1.0 - rise**2, 0.5) / 2  # steeper edges cut through a tip
    return curvatures


@kernel
def _fit(
    first: int,
    near: Graph,
    surface: Surroundings,
    values: Floats,
    degree: int,
    operators: Floats,
    hessians: Floats,
) -> None:
    """Fill in the tensors of the vertices from `first` on; they stay zero where not even a quadric fits."""
    indptr, indices = near
    points, normals, spacing = surface.vertices, surface.normals, surface.units
    heights, curvature = surface.heights, surface.curvature
    most = 1
    for i in range(len(indptr) - 1):
        most = max(most, indptr[i + 1] - indptr[i] + 1)
    size, right = (degree + 1) * (degree + 2) // 2, 1 + values.shape[1]
    chart, system = np.empty((most, 3)), np.empty((size + right, most))
    known, tensors = np.empty((most, right - 1)), np.empty((right, 3, 3))
    for i in range(len(indptr) - 1):
        v = first + i
        normal = normals[v]
        x, y = _tangents(normal)
        chart[0], known[0] = 0.0, 0.0
        count = 1
        for k in range(indptr[i], indptr[i + 1]):
            w = indices[k]
            if dot(normals[w], normal) < 0.3:  # normals that turn more: the neighbor is around the bend
                continue
            d = seen_from(v, w, points, heights, curvature) / spacing[v]
            chart[count, 0], chart[count, 1], chart[count, 2] = dot(d, x), dot(d, y), dot(d, normal)
            for j in range(right - 1):
                known[count, j] = values[w, j] - values[v, j]
            count += 1
        for lower in range(degree, 1, -1):
            needed = (lower + 1) * (lower + 2) // 2
            if count >= fewest(lower) and _solved(chart[:count], known[:count], lower, system[:, :count]):
                _set_tensors(system[needed : needed + right, :needed], x, y, normal, tensors)
                operators[v] = -tensors[0] / spacing[v]
                for j in range(1, right):
                    hessians[v, j - 1] = tensors[j] / (spacing[v] * spacing[v])
                break


@kernel
def _tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that complete a unit vector to a right-handed frame."""
    least = np.argmin(np.abs(normal))
    x = -normal[least] * normal
    x[least] += 1.0
    x /= np.sqrt(dot(x, x))
    y = np.array(
        [
            normal[1] * x[2] - normal[2] * x[1],
            normal[2] * x[0] - normal[0] * x[2],
            normal[0] * x[1] - normal[1] * x[0],
        ]
    )
    return x, y


@kernel
def _solved(chart: Floats, known: Floats, degree: int, system: Floats) -> bool:
    """Fit heights and values, by Householder's reflections; the coefficients replace the right-hand sides.

    The rows of `system` are first the columns of the monomials, then the heights and the values; those of
    degree d come before those of degree d + 1, and powers of the second coordinate rise within a degree.
    """
    m, size = len(chart), (degree + 1) * (degree + 2) // 2
    rows = size + 1 + known.shape[1]
    for k in range(m):
        p, q = chart[k, 0], chart[k, 1]
        root = 1.0 / np.sqrt(NEAR + p * p + q * q)
        system[0, k] = root
        at = 1
        for d in range(1, degree + 1):
            for power in range(d):
                system[at + power, k] = system[at + power - d, k] * p
            system[at + d, k] = system[at - 1, k] * q
            at += d + 1
        system[size, k] = root * chart[k, 2]
        for j in range(known.shape[1]):
            system[size + 1 + j, k] = root * known[k, j]
    for c in range(size):
        column = system[c]
        whole, left = dot(column, column), dot(column[c:], column[c:])
        if left <= 1e-6 * 1e-6 * whole:  # with less left of a column, the fit is not determined
            return False
        diagonal = -np.sqrt(left) if column[c] > 0 else np.sqrt(left)
        column[c] -= diagonal
        scale = -1.0 / (diagonal * column[c])
        for r in range(c + 1, rows):
            part = scale * dot(column[c:], system[r, c:])
            subtract_multiple(part, column[c:], system[r, c:])
        column[c] = diagonal  # the reflection has done its work
    for r in range(size, rows):
        solution = system[r]
        for c in range(size - 1, -1, -1):
            for j in range(c + 1, size):
                solution[c] -= system[j, c] * solution[j]
            solution[c] /= system[c, c]
    return True


@kernel
def _set_tensors(coefficients: Floats, x: Floats, y: Floats, normal: Floats, tensors: Floats) -> None:
    """Fill in the surface's second derivatives along its normal, then the Hessians of the functions.

    With z the height, the metric of the graph is ``g = 1 + dz dz``; its normal component of second
    derivatives is ``z_ij / W``, ``W^2 = 1 + |dz|^2``, and the Hessian of f is ``f_ij - z_ij (dz . df) /
    W^2``.
    """
    p, q = coefficients[0, 1], coefficients[0, 2]
    square = 1.0 + p * p + q * q
    # The dual basis of the tangent vectors (1, 0, p) and (0, 1, q).
    first = ((1.0 + q * q) * (x + p * normal) - p * q * (y + q * normal)) / square
    second = ((1.0 + p * p) * (y + q * normal) - p * q * (x + p * normal)) / square
    z = coefficients[0]
    for j in range(len(tensors)):
        f = coefficients[j]
        if j == 0:
            factor, slope = 1.0 / np.sqrt(square), 0.0
        else:
            factor, slope = 1.0, (p * f[1] + q * f[2]) / square
        xx = 2.0 * (factor * f[3] - slope * z[3])
        xy = factor * f[4] - slope * z[4]
        yy = 2.0 * (factor * f[5] - slope * z[5])
        for a in range(3):
            for b in range(3):
                mixed = first[a] * second[b] + second[a] * first[b]
                tensors[j, a, b] = xx * first[a] * first[b] + xy * mixed + yy * second[a] * second[b]
