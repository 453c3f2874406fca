"""Whether a surface is as smooth as its neighborhoods say: what tells it from others with the same lengths.

Near a smooth surface there are others with its lengths, to rounding, in which a few vertices stand on the
other side of their neighbors.  Here each vertex is compared with a cubic fitted to its neighbors alone, in a
polar chart: a neighbor keeps its distance from the vertex and its direction in the tangent plane.  In this
chart, unlike in a projection to the plane, the height of a sphere is a polynomial, and a neighborhood that
bends by more than a right angle does not fold over.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array

from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.convexity import FLAT
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.local_fit import ENOUGH, fit_residual_operator, neighborhoods
from isoembed.surface.measures import edge_lengths, vertex_normals

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

THREE_RINGS = 30  # more neighbors than two rings have
ROBUST = 2 / 3  # exponent of the mean
PLAIN = 0.2  # of the dihedral angles around: below it, the error of the fit may decide the sign


def offsets(triangulation: Triangulation, vertices: Floats) -> Floats:
    """How far each vertex stands out of the cubic fitted to its neighbors, along its normal, shape (V, 3).

    On smooth surfaces it shrinks with the fourth power of the edge length.  Zero where there is no normal.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)

    Returns
    -------
    ndarray, shape (V, 3)
        In the unit of the vertices, to be subtracted from them for the surface that the neighborhoods expect.
    """
    normals = vertex_normals(triangulation.faces, vertices)
    residuals = fit_residuals(triangulation, vertices) @ vertices
    return normals * np.einsum("ij,ij->i", residuals, normals)[:, None]


def fit_residuals(
    triangulation: Triangulation, vertices: Floats, degree: int = 3, least: int = ENOUGH
) -> csr_array:
    """``I - fit`` in the polar charts of a surface: what a function at a vertex adds to its neighborhood.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
        Of the surface whose charts are taken.
    degree : int
        Of the polynomials.
    least : int
        Where two rings have fewer neighbors than this, there are three.

    Returns
    -------
    csr_array, shape (V, V)
    """
    normals = vertex_normals(triangulation.faces, vertices)
    near = neighborhoods(triangulation, least)
    about = edge_lengths_about(triangulation, edge_lengths(triangulation.edges, vertices))
    return fit_residual_operator(near, _polar_charts(*near, vertices, normals, about), degree)


def quintic_residuals(triangulation: Triangulation, vertices: Floats) -> csr_array:
    """`fit_residuals` of quintics, over three rings."""
    return fit_residuals(triangulation, vertices, degree=5, least=THREE_RINGS)


def fine_roughness(triangulation: Triangulation, vertices: Floats) -> float:
    """What quintics fitted to three rings leave of what they leave, over the mean edge length there.

    Realizations that are less than a thousandth of an edge apart differ in it where their `roughness` does
    not: there, what a cubic misses of the smooth shape is more than what tells them apart.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)

    Returns
    -------
    float
        The mean over the vertices with the exponent 2/3: the few where edges are too long for the shape must
        not outweigh all others.
    """
    residuals = quintic_residuals(triangulation, vertices)
    twice = np.linalg.norm(residuals @ (residuals @ vertices), axis=1)
    about = edge_lengths_about(triangulation, edge_lengths(triangulation.edges, vertices))
    return float(np.mean((twice / about) ** ROBUST) ** (1 / ROBUST))


def roughness(triangulation: Triangulation, vertices: Floats, offsets: Floats) -> float:
    """Root mean square, over the vertices, of the offset over the mean length of the vertex's edges.

    Near surfaces with the same lengths are told apart by `fine_roughness`.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    offsets : ndarray, shape (V, 3)
        From the function of this name.
    """
    relative = np.linalg.norm(offsets, axis=1) / edge_lengths_about(
        triangulation, edge_lengths(triangulation.edges, vertices)
    )
    return float(np.sqrt(np.mean(relative**2)))


def rough_edges(triangulation: Triangulation, vertices: Floats, offsets: Floats) -> Mask:
    """Edges that bend against their neighborhood, shape (E,).

    The dihedral angle of such an edge has another sign than the one between the same triangles when their
    four vertices have moved to where their neighbors expect them, and both angles are plain: beyond FLAT, and
    beyond a fifth of what is typical, the root mean square of the expected angles around.  The mean is taken
    over the edges at each vertex, then over each end of the edge with its neighbors, then over both ends.
    Nor does an edge bend against its neighborhood if no edge that it meets bends the other way: convex bodies
    have no rough edges, however coarse.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    offsets : ndarray, shape (V, 3)
        From the function of this name.
    """
    found = dihedral_angles(triangulation, vertices)
    expected = dihedral_angles(triangulation, vertices - offsets)
    degrees = triangulation.degrees
    squares = _sums_at_ends(triangulation, expected**2) / degrees
    around = (triangulation.adjacency @ squares + squares) / (degrees + 1)
    typical = np.sqrt(around[triangulation.edges].mean(axis=1))
    plain = np.minimum(np.abs(found), np.abs(expected)) > np.maximum(FLAT, PLAIN * typical)
    meets_convex, meets_concave = (
        (_sums_at_ends(triangulation, bent) > 0)[triangulation.edges].any(axis=1)
        for bent in (found > FLAT, found < -FLAT)
    )
    opposed = np.where(found > 0, meets_concave, meets_convex)
    return plain & opposed & ((found > 0) != (expected > 0))


def edge_lengths_about(triangulation: Triangulation, lengths: Floats) -> Floats:
    """The mean length of the edges at each vertex, (V,); 1 if it is zero, where there is no normal either.

    Parameters
    ----------
    triangulation : Triangulation
    lengths : ndarray, shape (E,)
    """
    means = _sums_at_ends(triangulation, lengths) / triangulation.degrees
    return np.where(means > 0, means, 1.0)


def _sums_at_ends(triangulation: Triangulation, values: Floats | Mask) -> Floats:
    """At each vertex the sum of the values of its edges, (V,)."""
    return cast(Floats, np.bincount(triangulation.edges.ravel(), np.repeat(values, 2)))


@njit(cache=True)
def _polar_charts(
    indptr: Indices, indices: Indices, vertices: Floats, normals: Floats, units: Floats
) -> Floats:
    """Directions of the neighbors in each vertex's tangent plane, times distances in its unit, (nnz, 2)."""
    charts = np.zeros((len(indices), 2))
    first, second = np.empty(3), np.empty(3)  # perpendicular to each other and to the normal, of equal size
    for v in range(len(indptr) - 1):
        normal = normals[v]
        k = np.argmin(np.abs(normal))
        i, j = (k + 1) % 3, (k + 2) % 3
        first[k], first[i], first[j] = 0.0, -normal[j], normal[i]
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normal[a] * first[b] - normal[b] * first[a]
        for at in range(indptr[v], indptr[v + 1]):
            x, y, square = 0.0, 0.0, 0.0
            for c in range(3):
                d = vertices[indices[at], c] - vertices[v, c]
                x += first[c] * d
                y += second[c] * d
                square += d * d
            in_plane = np.sqrt(x * x + y * y)
            if in_plane > 0.0:
                stretch = np.sqrt(square) / (in_plane * units[v])
                charts[at, 0], charts[at, 1] = stretch * x, stretch * y
    return charts
