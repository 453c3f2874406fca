"""Roughness measures of a surface, and rough edges.

Near a smooth surface there are others with the same lengths, up to rounding, in which a few vertices are on
the other side of their neighbors.  Here each vertex is compared with a cubic fitted to its neighbors only, in
a polar chart, which preserves the distances of the neighbors from the vertex and their directions in the
tangent plane.  In this chart, unlike in a projection to the plane, the height of a sphere is a polynomial,
and a neighborhood that bends by more than a right angle does not fold over.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, vstack

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.curvature import FLAT_ANGLE, dihedral_angles
from isoembed.surface.local_fit import FitResiduals, Surroundings, edge_lengths_about, sums_at_ends
from isoembed.surface.measures import edge_lengths
from isoembed.surface.normal_fits import THREE_RINGS, TWO_RINGS
from isoembed.surface.smoothness_loops import polar_charts, subtract_products
from isoembed.surface.spatial_order import spatial_order
from isoembed.threads import run_ranges

ROWS = 5_000  # products with fewer take less time than starting a thread
CHUNK = 1 << 16  # vertices fitted at once, which bounds the memory of their charts
ROBUST_EXPONENT = 2 / 3  # of the power mean of the residuals of quintics, which discounts outliers


Ordered = tuple[Indices, Surroundings]


def in_spatial_order(triangulation: Triangulation, vertices: Floats) -> Ordered:
    """The `spatial_order` of the vertices, and the surface renumbered in this order."""
    order = spatial_order(vertices)
    return order, Surroundings.of(triangulation, vertices).in_order(order)


def offsets(triangulation: Triangulation, vertices: Floats, ordered: Ordered | None = None) -> Floats:
    """Offset of each vertex from the cubic fitted to its neighbors, along its normal, shape (V, 3).

    On smooth surfaces it decreases with the fourth power of the edge length.  Zero where there is no normal.
    Subtracting it from the vertices gives the surface predicted by the neighborhoods.  `ordered` is the
    result of `in_spatial_order`, if known.
    """
    order, surface = ordered or in_spatial_order(triangulation, vertices)
    residuals = _fit_errors(_residuals(surface), surface.vertices)
    found = np.empty_like(residuals)
    found[order] = surface.normals * np.einsum("ij,ij->i", residuals, surface.normals)[:, None]
    return found


def fit_residuals(triangulation: Triangulation, vertices: Floats, degree: int = 3) -> csr_array:
    """Matrix ``I - fit`` of the residuals of polynomial fits in the polar charts of a surface, (V, V).

    Polynomials of degree above 3 are fitted to three rings of neighbors.
    """
    n = triangulation.n_vertices
    blocks = _residuals(Surroundings.of(triangulation, vertices), degree)
    return csr_array(vstack([block.matrix(n) for block in blocks], format="csr"))


@dataclass(frozen=True, eq=False)
class QuinticResiduals:
    """Matrix R of differences from quintics fitted to each vertex's neighbors, in the charts of one surface.

    The rows have unit norm.

    Attributes
    ----------
    order : ndarray of int, shape (V,)
        Spatial order of the vertices, in which the other attributes are.
    neighbors : csr_array, (V, V)
        Weights of the neighbors, subtracted.
    own : ndarray, shape (V,)
        Weights of the vertices themselves.
    units : ndarray, shape (V,)
        Mean edge length at each vertex.
    """

    order: Indices
    neighbors: csr_array
    own: Floats
    units: Floats

    @classmethod
    def of(cls, triangulation: Triangulation, vertices: Floats) -> QuinticResiduals:
        """Residuals in the charts of a surface."""
        order, surface = in_spatial_order(triangulation, vertices)
        blocks = list(_residuals(surface, 5))
        degrees = np.concatenate([np.diff(block.indptr) for block in blocks])
        indices = np.concatenate([block.indices.astype(np.int32) for block in blocks])
        weights = np.concatenate([block.weights for block in blocks])
        row = np.repeat(np.arange(len(order)), degrees)
        own = 1 / np.sqrt(1 + np.bincount(row, weights**2))
        indptr = np.r_[0, np.cumsum(degrees)].astype(np.int32)
        neighbors = csr_array((weights * own[row], indices, indptr), shape=(len(order), len(order)))
        return cls(order, neighbors, own, surface.units)

    def pull(self, vectors: Floats) -> Floats:
        """``R^T R^T R R v``, (V, 3): half the gradient of ``|R R v|^2``."""
        pulls = np.empty_like(vectors)
        pulls[self.order] = self._transposed(self._transposed(self._times(self._times(vectors[self.order]))))
        return pulls

    def roughness(self, vertices: Floats) -> float:
        """Return the `fine_roughness` of vertices near this surface."""
        size = self.own[:, None]
        twice = self._times(self._times(vertices[self.order]) / size) / size
        return robust_mean(np.linalg.norm(twice, axis=1) / self.units)

    def _times(self, vectors: Floats) -> Floats:
        return self._product(self.neighbors, vectors)

    def _transposed(self, vectors: Floats) -> Floats:
        return self._product(self._of_neighbors, vectors)

    @cached_property
    def _of_neighbors(self) -> csr_array:
        return csr_array(self.neighbors.T)

    def _product(self, neighbors: csr_array, vectors: Floats) -> Floats:
        products = np.empty_like(vectors)
        run_ranges(
            lambda rows: subtract_products(neighbors, rows, self.own, vectors, products), len(vectors), ROWS
        )
        return products


def misfits(triangulation: Triangulation, vertices: Floats, values: Floats, degree: int = 4) -> Floats:
    """Differences of values (V, 3) from polynomials fitted to their neighbors' values only, (V, 3).

    For smooth functions they decrease with a power of the edge length; noise is slightly amplified.
    """
    return _fit_errors(_residuals(Surroundings.of(triangulation, vertices), degree), values)


def _residuals(surface: Surroundings, degree: int = 3) -> Iterator[FitResiduals]:
    """Yield `fit_residuals` in chunks of vertices, which bounds the memory of the charts."""
    minimum = TWO_RINGS if degree <= 3 else THREE_RINGS
    for first, near in surface.neighborhoods(minimum, CHUNK):
        yield FitResiduals.of(first, near, polar_charts(first, *near, surface), degree)


def _fit_errors(blocks: Iterable[FitResiduals], values: Floats) -> Floats:
    """Residuals of values, (V, 3), in the fits of all vertices."""
    return np.concatenate([block @ values for block in blocks])


def fine_roughness(triangulation: Triangulation, vertices: Floats, ordered: Ordered | None = None) -> float:
    """Power mean of the twice-applied residuals of quintic fits to three rings, in mean edge lengths.

    It distinguishes realizations less than a thousandth of an edge apart, for which the difference in
    `roughness` is masked by the error of cubic fits to the smooth shape.  The power mean over the vertices
    has the exponent 2/3, so that the few vertices where edges are too long for the shape do not dominate.
    `ordered` is the result of `in_spatial_order`, if known.
    """
    _, surface = ordered or in_spatial_order(triangulation, vertices)
    blocks = list(_residuals(surface, 5))
    twice = np.linalg.norm(_fit_errors(blocks, _fit_errors(blocks, surface.vertices)), axis=1)
    return robust_mean(twice / surface.units)


def robust_mean(values: Floats) -> float:
    """Power mean with `ROBUST_EXPONENT`, in which a few large values do not dominate."""
    return float(np.mean(values**ROBUST_EXPONENT) ** (1 / ROBUST_EXPONENT))


def roughness(triangulation: Triangulation, vertices: Floats, offsets: Floats) -> float:
    """Root mean square of the vertices' `offsets`, relative to the mean length of the edges at each vertex.

    Nearby surfaces with the same lengths are distinguished by `fine_roughness`.
    """
    relative = np.linalg.norm(offsets, axis=1) / edge_lengths_about(
        triangulation, edge_lengths(triangulation.edges, vertices)
    )
    return float(np.sqrt(np.mean(relative**2)))


def rough_edges(
    triangulation: Triangulation, vertices: Floats, offsets: Floats, angles: Floats | None = None
) -> Mask:
    """Edges that bend against their neighborhood, shape (E,), given the `offsets`.

    The dihedral angle of such an edge has the opposite sign of the expected one, between the same triangles
    after their four vertices are moved to the positions predicted by their neighbors.  Both angles must be
    significant: not flat, and greater than a fifth of the root mean square of the expected angles nearby.
    The mean is taken over the edges at each vertex, then over each end of the edge with its neighbors, then
    over both ends.  An edge must also meet an edge that bends the other way: convex bodies have no rough
    edges, however coarse.  `angles` are the `dihedral_angles`, if known.
    """
    found = dihedral_angles(triangulation, vertices) if angles is None else angles
    expected = dihedral_angles(triangulation, vertices - offsets)
    degrees = triangulation.degrees
    squares = sums_at_ends(triangulation, expected**2) / degrees
    around = (triangulation.adjacency @ squares + squares) / (degrees + 1)
    typical = np.sqrt(around[triangulation.edges].mean(axis=1))
    # smaller angles may have their sign from errors
    plain = np.minimum(np.abs(found), np.abs(expected)) > np.maximum(FLAT_ANGLE, 0.2 * typical)
    meets_convex, meets_concave = (
        (sums_at_ends(triangulation, bent) > 0)[triangulation.edges].any(axis=1)
        for bent in (found > FLAT_ANGLE, found < -FLAT_ANGLE)
    )
    opposed = np.where(found > 0, meets_concave, meets_convex)
    return plain & opposed & ((found > 0) != (expected > 0))
