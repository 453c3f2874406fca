"""Whether a surface is as smooth as its neighborhoods say: what tells it from others with the same lengths.

Near a smooth surface there are others with its lengths, to rounding, in which a few vertices stand on the
other side of their neighbors.  Here each vertex is compared with a cubic fitted to its neighbors alone, in a
polar chart: a neighbor keeps its distance from the vertex and its direction in the tangent plane.  In this
chart, unlike in a projection to the plane, the height of a sphere is a polynomial, and a neighborhood that
bends by more than a right angle does not fold over.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import cast

import numpy as np
from numba import njit
from scipy.sparse import csr_array, vstack

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.convexity import FLAT
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.local_fit import ENOUGH, FitResiduals, neighborhoods
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.spatial_order import reordered, spatial_order

QUINTIC = 5  # degree
THREE_RINGS = 30  # more neighbors than two rings have
ROBUST = 2 / 3  # exponent of the mean
BLOCK = 1 << 16  # vertices whose fits are made together
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
    order = spatial_order(vertices)
    surface = _Surroundings.of(triangulation, vertices).in_order(order)
    residuals = _left(surface.residuals(), surface.vertices)
    found = np.empty_like(residuals)
    found[order] = surface.normals * np.einsum("ij,ij->i", residuals, surface.normals)[:, None]
    return found


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
    n = triangulation.n_vertices
    blocks = _Surroundings.of(triangulation, vertices).residuals(degree, least)
    return csr_array(vstack([block.matrix(n) for block in blocks], format="csr"))


def quintic_residuals(triangulation: Triangulation, vertices: Floats) -> csr_array:
    """`fit_residuals` of quintics, over three rings."""
    return fit_residuals(triangulation, vertices, QUINTIC, THREE_RINGS)


@dataclass(frozen=True)
class _Surroundings:
    """A surface with what its polar charts are made of.

    Attributes
    ----------
    graph : (indptr, indices)
        Of the adjacency.
    vertices, normals : ndarray, shape (V, 3)
    units : ndarray, shape (V,)
        The mean edge length about each vertex.
    """

    graph: tuple[Indices, Indices]
    vertices: Floats
    normals: Floats
    units: Floats

    @classmethod
    def of(cls, triangulation: Triangulation, vertices: Floats) -> _Surroundings:
        adjacency = triangulation.adjacency
        normals = vertex_normals(triangulation.faces, vertices)
        units = edge_lengths_about(triangulation, edge_lengths(triangulation.edges, vertices))
        return cls((adjacency.indptr, adjacency.indices), vertices, normals, units)

    def in_order(self, order: Indices) -> _Surroundings:
        """The same surface, its vertices numbered in another order."""
        graph = reordered(*self.graph, order)
        return _Surroundings(graph, self.vertices[order], self.normals[order], self.units[order])

    def residuals(self, degree: int = 3, least: int = ENOUGH) -> Iterator[FitResiduals]:
        """`fit_residuals` of some vertices after the other: the charts of all at once take much memory."""
        n = len(self.vertices)
        for first in range(0, n, BLOCK):
            near = neighborhoods(self.graph, least, range(first, min(first + BLOCK, n)))
            charts = _polar_charts(first, *near, self.vertices, self.normals, self.units)
            yield FitResiduals.of(first, near, charts, degree)


def _left(blocks: Iterable[FitResiduals], values: Floats) -> Floats:
    """What the fits of all vertices leave of values, (V, 3)."""
    return np.concatenate([block @ values for block in blocks])


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
    surface = _Surroundings.of(triangulation, vertices).in_order(spatial_order(vertices))
    blocks = list(surface.residuals(QUINTIC, THREE_RINGS))
    twice = np.linalg.norm(_left(blocks, _left(blocks, surface.vertices)), axis=1)
    return float(np.mean((twice / surface.units) ** ROBUST) ** (1 / ROBUST))


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


@njit(cache=True, error_model="numpy")
def _polar_charts(
    begin: int, indptr: Indices, indices: Indices, vertices: Floats, normals: Floats, units: Floats
) -> Floats:
    """Directions of neighbors in the tangent planes of vertices, times distances in their units, (nnz, 2)."""
    charts = np.zeros((len(indices), 2))
    first, second = np.empty(3), np.empty(3)  # perpendicular to each other and to the normal, of equal size
    for row in range(len(indptr) - 1):
        v = begin + row
        normal, here, unit = normals[v], vertices[v], units[v]
        k = 0
        for c in (1, 2):
            if abs(normal[c]) < abs(normal[k]):
                k = c
        i, j = (k + 1) % 3, (k + 2) % 3
        first[k], first[i], first[j] = 0.0, -normal[j], normal[i]
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normal[a] * first[b] - normal[b] * first[a]
        for at in range(indptr[row], indptr[row + 1]):
            there = vertices[indices[at]]
            dx, dy, dz = there[0] - here[0], there[1] - here[1], there[2] - here[2]
            x = first[0] * dx + first[1] * dy + first[2] * dz
            y = second[0] * dx + second[1] * dy + second[2] * dz
            in_plane = x * x + y * y
            if in_plane > 0.0:
                stretch = np.sqrt((dx * dx + dy * dy + dz * dz) / in_plane) / unit
                charts[at, 0], charts[at, 1] = stretch * x, stretch * y
    return charts
