"""Embeddings with polygonal faces."""

from dataclasses import dataclass
from typing import Any

from isoembed.arrays import Mask
from isoembed.embedding.embedding import Embedding
from isoembed.metric.curvature import deficits
from isoembed.surface.curvature import FLAT_ANGLE
from isoembed.surface.surface import Surface


@dataclass(frozen=True, eq=False, repr=False)
class Polyhedron(Embedding):
    """Embedding as a convex polyhedron with polygonal faces.

    The `polygons` are convex, each of one or more triangles that are coplanar within the errors of rounded
    coordinates or lengths.
    """

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        return super()._made_surface(kind, flat_vertices=self._flat, **more)

    @property
    def _flat(self) -> Mask:
        """Mask of vertices inside faces and edges, shape (V,)."""
        return deficits(self.metric) <= FLAT_ANGLE
