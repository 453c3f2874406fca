"""Half-edge tables of an intrinsic triangulation, changed in place by flips.

Half-edge ``h = 3 f + c`` leaves corner c of face f and is followed by that of the next corner.  The
triangulation need not be a simplicial complex: loops, multiple edges and triangles glued to themselves are
allowed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.loops import Mesh, breadth_first, by_lowest_corner, set_directions


class HalfEdges(NamedTuple):
    """Triangles as tables over their half-edges.

    Attributes
    ----------
    corners : ndarray of int64, shape (3F,)
        Start vertex of each half-edge.
    twins : ndarray of int64, shape (3F,)
        Half-edge glued to each half-edge.
    lengths : ndarray, shape (3F,)
    directions : ndarray, shape (3F,)
        Angle of each half-edge at its start, counterclockwise from a direction unchanged by flips and modulo
        the total angle there (a "signpost": Sharp, Soliman and Crane, Navigating intrinsic triangulations,
        ACM TOG 38, 2019).  Empty if not needed.
    curvature : float
        Gaussian curvature of the triangles; lengths are measured along their sides.
    """

    corners: Indices
    twins: Indices
    lengths: Floats
    directions: Floats
    curvature: float = 0.0

    @classmethod
    def of(cls, faces: Indices, twins: Indices, face_lengths: Floats, curvature: float = 0.0) -> HalfEdges:
        """Copy the triangles of a metric and compute the directions of the half-edges.

        Parameters
        ----------
        faces : ndarray of int, shape (F, 3)
        twins : ndarray of int, shape (3F,)
        face_lengths : ndarray, shape (F, 3)
            Length of each half-edge.
        curvature : float
            Gaussian curvature of the triangles.
        """
        mesh = cls.without_directions(faces, twins, face_lengths, curvature)
        mesh = mesh._replace(directions=np.zeros(mesh.corners.size))
        set_directions(mesh.views)
        return mesh

    @classmethod
    def without_directions(
        cls, faces: Indices, twins: Indices, face_lengths: Floats, curvature: float = 0.0
    ) -> HalfEdges:
        """Copy the triangles of a metric, without directions."""
        corners = np.array(faces, dtype=np.int64, order="C").ravel()
        lengths = np.array(face_lengths, dtype=np.float64, order="C").ravel()
        return cls(corners, np.array(twins, dtype=np.int64), lengths, np.empty(0), float(curvature))

    def copy(self) -> HalfEdges:
        """Copy of all tables."""
        return HalfEdges(
            self.corners.copy(),
            self.twins.copy(),
            self.lengths.copy(),
            self.directions.copy(),
            self.curvature,
        )

    def order_in_memory(self) -> Indices:
        """Order of the vertices in which neighbors have nearby indices, shape (V,)."""
        return breadth_first(self.corners, self.twins)

    def in_order(self, order: Indices) -> HalfEdges:
        """Copy with renumbered vertices and faces, so that neighbors are close in memory.

        Parameters
        ----------
        order : ndarray of int, shape (V,)
            Old index of each new vertex; faces are ordered by their lowest vertex.
        """
        number = np.empty_like(order)
        number[order] = np.arange(order.size)
        corners = number[self.corners]
        return self._replace(corners=corners).of_faces(by_lowest_corner(corners))

    def of_faces(self, faces: Indices) -> HalfEdges:
        """Copy of some faces, in this order, that are glued only to each other."""
        place = np.empty(self.corners.size // 3, dtype=np.int64)
        place[faces] = np.arange(faces.size)
        h = (3 * faces[:, None] + np.arange(3)).ravel()
        face, corner = np.divmod(self.twins[h], 3)
        return self._replace(
            corners=self.corners[h],
            twins=3 * place[face] + corner,
            lengths=self.lengths[h],
            directions=self.directions[h] if len(self.directions) else self.directions,
        )

    @property
    def views(self) -> Mesh:
        """Views of the tables for `loops`, which modify them in place."""
        return Mesh(self)

    @property
    def faces(self) -> Indices:
        """Vertex at each corner, shape (F, 3)."""
        return self.corners.reshape(-1, 3)

    @property
    def face_lengths(self) -> Floats:
        """Length of each half-edge, shape (F, 3)."""
        return self.lengths.reshape(-1, 3)

    @property
    def ends(self) -> tuple[Indices, Indices]:
        """Start and end vertex of each half-edge."""
        return self.corners, self.corners[self.twins]

    @property
    def edges(self) -> Indices:
        """Lower half-edge of each edge, ascending, shape (E,)."""
        return np.flatnonzero(np.arange(self.twins.size) < self.twins)
