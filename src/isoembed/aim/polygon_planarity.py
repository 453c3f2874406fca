"""Planarity of given polygons, from the diagonals into which they were cut.

Two triangles on either side of a diagonal are coplanar, and not folded onto each other, if the segment
between their apexes crosses the diagonal where it does in the plane.  That is linear in the vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.metric.polygon_faces import ERRORS, PLANAR
from isoembed.metric.polyhedral import PolyhedralMetric


@dataclass(frozen=True, eq=False)
class PolygonPlanarity:
    """Distances of the diagonals of polygons from the segments between the apexes on their two sides.

    Attributes
    ----------
    crossings : sparse, shape (D, V)
        A row per diagonal: the point of the segment between the apexes, less that of the diagonal.
    tolerances : ndarray, shape (D,)
        Distances allowed between them.
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
        shares = heights[::-1] / heights.sum(axis=0)
        place = (shares * feet).sum(axis=0) / base
        start = t.faces.ravel()
        count = np.arange(len(base))
        rows = np.concatenate([count] * 4)
        columns = np.concatenate([start[before[0]], start[before[1]], start[left], start[after[0]]])
        values = np.concatenate([*shares, place - 1, -place])
        crossings = csr_array((values, (rows, columns)), shape=(len(base), t.n_vertices))
        error = 0.0 if metric.precision is None else metric.precision.vertex_error * metric.mean_length
        return cls(crossings, 2 * np.maximum(PLANAR * base, ERRORS * error))

    def offsets(self, vertices: Floats) -> Floats:
        """Vectors between the two points of each diagonal, shape (D, 3)."""
        return np.asarray(self.crossings @ vertices)

    def holds(self, vertices: Floats) -> bool:
        """Whether all polygons are planar within the tolerances."""
        return bool((np.linalg.norm(self.offsets(vertices), axis=1) <= self.tolerances).all())


def has_planar_polygons(surface: Embedding) -> bool:
    """Whether all polygons given with the metric are planar; also if there are none, or in curved space."""
    metric = surface.metric
    if not len(metric.diagonals) or not metric.space.is_euclidean:
        return True
    return PolygonPlanarity.of(metric).holds(surface.vertices)
