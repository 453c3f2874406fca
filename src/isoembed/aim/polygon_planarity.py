"""Planarity constraints of polygonal faces, as linear equations in the vertices.

Polygons are cut into triangles along diagonals.  The two triangles at a diagonal are coplanar, and not folded
onto each other, if the segment between their apexes crosses the diagonal where it does in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.metric.polygon_faces import ERRORS, PLANAR
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.flat_faces import flat_faces


@dataclass(frozen=True, eq=False)
class PolygonPlanarity:
    """Distances of the diagonals of polygons from the segments between the apexes on their two sides.

    Attributes
    ----------
    crossings : sparse, shape (D, V)
        A row per diagonal: the point of the segment between the apexes, less that of the diagonal.
    tolerances : ndarray, shape (D,)
        Distances allowed between them: those of polygons that count as planar in a mesh.
    """

    crossings: csr_array
    tolerances: Floats

    @classmethod
    def of(cls, metric: PolyhedralMetric) -> PolygonPlanarity:
        """Planarity of the polygons of a Euclidean metric, from its `diagonals`."""
        t, lengths = metric.triangulation, metric.face_lengths.ravel()
        left, right = t.edge_flanks[metric.diagonals].T
        after, before = (
            np.stack([side - side % 3 + (side + turn) % 3 for side in (left, right)]) for turn in (1, 2)
        )
        base = lengths[left]
        # Foot and height of each apex, from the start of the half-edge on its side.
        feet = (base**2 + lengths[before] ** 2 - lengths[after] ** 2) / (2 * base)
        heights = np.sqrt(np.maximum(lengths[before] ** 2 - feet**2, 0.0))
        feet[1] = base - feet[1]
        total = heights.sum(axis=0)  # zero if all four points are on a line, up to rounding
        shares = np.divide(heights[::-1], total, out=np.full_like(heights, 0.5), where=total > 0)
        place = (shares * feet).sum(axis=0) / base
        start = t.faces.ravel()
        count = np.arange(len(base))
        rows = np.concatenate([count] * 4)
        columns = np.concatenate([start[before[0]], start[before[1]], start[left], start[after[0]]])
        values = np.concatenate([*shares, place - 1, -place])
        crossings = csr_array((values, (rows, columns)), shape=(len(base), t.n_vertices))
        error = 0.0 if metric.precision is None else metric.precision.vertex_error * metric.mean_length
        off = np.maximum(PLANAR * _sizes(metric)[left // 3], ERRORS * error)  # of a vertex from the plane
        # Twice as much, as the lengths of a bent polygon differ to second order.
        return cls(crossings, 2 * abs(crossings).sum(axis=1) * off)

    def offsets(self, vertices: Floats) -> Floats:
        """Vectors between the two points of each diagonal, shape (D, 3)."""
        return np.asarray(self.crossings @ vertices)

    def holds(self, vertices: Floats) -> bool:
        """Whether all polygons are planar within the tolerances."""
        return bool((np.linalg.norm(self.offsets(vertices), axis=1) <= self.tolerances).all())


def _sizes(metric: PolyhedralMetric) -> Floats:
    """Half the perimeter of the polygon of each triangle, which exceeds its size, shape (F,)."""
    t = metric.triangulation
    is_side = np.ones(t.n_edges, dtype=np.bool_)
    is_side[metric.diagonals] = False
    is_side = is_side[t.face_edges]
    polygons = flat_faces(t, is_side.ravel())
    perimeters = np.bincount(polygons, np.sum(metric.face_lengths * is_side, axis=1))
    return np.asarray(perimeters[polygons] / 2)


def has_planar_polygons(surface: Embedding) -> bool:
    """Whether all polygons given with the metric are planar; also if there are none, or in curved space."""
    metric = surface.metric
    if not len(metric.diagonals) or not metric.space.is_euclidean:
        return True
    return PolygonPlanarity.of(metric).holds(surface.vertices)
