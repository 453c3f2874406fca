"""A surface with flat faces that are more than triangles."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.embedding import Embedding
from isoembed.mesh.triangulation import frozen
from isoembed.metric.curvature import deficits
from isoembed.surface.curvature import FLAT_ANGLE
from isoembed.surface.flat_faces import coplanar_faces, outlines
from isoembed.surface.measures import triangle_areas


@dataclass(frozen=True, eq=False, repr=False)
class Polyhedron(Embedding):
    """A convex surface with its true faces; an `Embedding` otherwise.

    Its faces are convex polygons, each of one triangle or of several that lie in one plane.
    """

    @cached_property
    def face_polygons(self) -> Indices:
        """The face of the polyhedron that each triangle is part of, shape (F,).

        Triangles are in one face where the dihedral angle between them is below 1e-7 radians.  Those that
        rounding may turn by more are in the face that they are bent least to.  Where the coordinates that the
        lengths come from were rounded, angles that this may have made do not count either.
        """
        return frozen(coplanar_faces(self.triangulation, self._normalized, self._space, self._vertex_error))

    @cached_property
    def polygons(self) -> tuple[Indices, ...]:
        """The faces of the polyhedron: the vertices around each, counterclockwise seen from outside.

        Flat vertices on an edge of the polyhedron are in the outlines, those inside a face are not.
        """
        start, faces = self.faces.ravel(), self.face_polygons
        polygons: list[Indices] = [np.zeros(0, dtype=np.int64)] * (int(faces.max()) + 1)
        lengths = self.metric.lengths[self.triangulation.face_edges.ravel()]
        ways = outlines(self.triangulation, self._creased)
        for way in sorted(ways, key=lambda way: float(lengths[way].sum())):  # holes first
            polygons[faces[way[0] // 3]] = frozen(start[way])
        return tuple(polygons)

    @cached_property
    def face_sides(self) -> Indices:
        """How many sides each of the `polygons` has, flat vertices on its outline left aside."""
        flat = self._flat[np.concatenate(self.polygons)]
        ends = np.cumsum([len(polygon) for polygon in self.polygons])
        return frozen(np.diff(np.cumsum(~flat)[ends - 1], prepend=0).astype(np.int64))

    @cached_property
    def polygon_edges(self) -> Mask:
        """The edges of the polyhedron among those of the triangles, shape (E,): between two of its faces."""
        left, right = self.face_polygons[self.triangulation.edge_faces].T
        return frozen(left != right)

    @property
    def _creased(self) -> Mask:
        """Half-edges on edges of the polyhedron."""
        return self.polygon_edges[self.triangulation.face_edges.ravel()]

    @cached_property
    def _vertex_areas(self) -> Floats:
        """Each face's area goes in equal parts to the vertices in it, wherever its diagonals are."""
        t = self.triangulation
        whole = np.bincount(self.face_polygons, triangle_areas(t.faces, self._normalized, self._space))
        polygon = np.repeat(self.face_polygons, 3)
        polygon, vertex = np.unique(np.column_stack([polygon, t.faces.ravel()]), axis=0).T
        shares = whole / np.bincount(polygon)
        return frozen(np.bincount(vertex, shares[polygon]).astype(np.float64))

    @property
    def _flat(self) -> Mask:
        """The vertices that lie inside faces and edges, shape (V,)."""
        return deficits(self.metric) <= FLAT_ANGLE
