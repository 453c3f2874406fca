"""Drawing of surfaces in hyperbolic and spherical space in a conformal model.

Hyperbolic space is drawn as Poincare ball, spherical space in stereographic projection.  Geodesic edges are
circular arcs in these models, and planar faces parts of spheres; large ones are subdivided.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.io.format import Polygons
from isoembed.io.title_line import WRITTEN
from isoembed.plot.coloring import Quantity, face_means
from isoembed.plot.pieces import Pieces, middles
from isoembed.plot.view import Pose
from isoembed.space import Space
from isoembed.space.models import radius_of, to_model
from isoembed.surface.segments import Segments

MAX_BEND = 1e-3  # half diameters: maximal distance of a straight piece of an edge from the arc
MAX_PIECES = 20_000  # limit of subdivision
BALL_RADIUS = 6.0  # half diameters: a larger sphere at infinity is not drawn


@dataclass(frozen=True, eq=False)
class Drawn:
    """Drawing of a surface, or of others with the same triangulation.

    Attributes
    ----------
    surface : Embedding
    center : ndarray, shape (3,)
        Point of space that is translated to the origin.
    pieces : Pieces
        Triangles, subdivided where their curvature in the model is visible.
    """

    surface: Embedding
    center: Floats
    pieces: Pieces

    @classmethod
    def of(cls, surface: Embedding) -> Drawn:
        """Drawing of a surface; in R^3 no transformation is applied."""
        space, pieces = surface.space, Pieces.whole(surface.faces, surface.metric.edges)
        if space.is_euclidean:
            return cls(surface, np.zeros(3), pieces)
        drawn = cls(surface, _center(space, surface.vertices), pieces)
        while drawn._bend > MAX_BEND and 4 * len(drawn.pieces.faces) <= MAX_PIECES:
            drawn = cls(surface, drawn.center, drawn.pieces.cut())
        return drawn

    @property
    def space(self) -> Space:
        """Space that contains the surface."""
        return self.surface.space

    @property
    def infinity(self) -> float:
        """Radius of the sphere at infinity about the origin of the model; infinite if there is none."""
        return radius_of(self.space, WRITTEN) if self.space.curvature < 0 else np.inf

    @property
    def faces(self) -> Polygons:
        """Faces of the drawing: those of the surface, or the pieces of its triangles."""
        return self.pieces.faces if self.pieces.cuts else self.surface.polygons

    def points(self, vertices: Floats) -> Floats:
        """Points of space at the vertices of the drawing, for given vertices (V, 3) of the surface."""
        if self.space.is_euclidean:
            return vertices
        return self.pieces.points(self.space, self.space.translated(vertices, -self.center))

    def put(self, vertices: Floats) -> Floats:
        """Model coordinates of the vertices of the drawing, for given vertices (V, 3) of the surface."""
        return to_model(self.space, self.points(vertices), WRITTEN)

    def pose(self, vertices: Floats) -> Pose:
        """Pose of the drawing by the given vertices (V, 3): pieces depend on the diagonals of polygons."""
        placed = self.put(vertices)
        pose = Pose.of(placed[: len(vertices)], self.surface.faces)
        reach = float(np.linalg.norm(pose.put(placed), axis=1).max())
        return replace(pose, size=pose.size * (reach or 1.0))

    def face_values(self, shown: Quantity) -> Floats:
        """Values of the drawn faces; the pieces of a face share its value."""
        faces, pieces = self.surface.surface.flat_faces, self.pieces
        values = shown.values if shown.at == "faces" else face_means(shown.values, faces.polygons)
        return np.repeat(values[faces.of_triangles], pieces.per_face) if pieces.cuts else values

    def spread(self, shown: Quantity) -> Quantity:
        """Quantity at the vertices of the drawing; face quantities are returned unchanged."""
        if shown.at == "faces":
            return shown
        return replace(shown, values=self.pieces.values(shown.values))

    def outlines(self, placed: Floats) -> Segments | None:
        """Edges between faces, placed by `put`; None if the drawn faces have these outlines anyway."""
        if not self.pieces.cuts:
            return None
        between = self.surface.surface.flat_faces.edges[self.pieces.owners]
        return Segments(placed[self.pieces.edges[between]], self.pieces.beside()[between])

    def boundary(self, placed: Floats) -> Segments:
        """Boundary edges of a surface in R^3, placed by `put`."""
        t = self.surface.triangulation
        beside = self.surface.surface.flat_faces.of_triangles[t.edge_flanks[t.boundary_edges] // 3]
        return Segments(placed[t.edges[t.boundary_edges]], beside)

    def seams_in_space(self) -> Segments:
        """Seams of a net in pieces, between points of space, and the adjacent triangles."""
        ends, beside = self.surface.surface.seams
        if self.space.is_euclidean or not len(ends):
            return Segments(ends, beside)
        ends = self.space.translated(ends, -self.center)
        for _ in self.pieces.parents:
            halves = middles(self.space, ends)[:, None]
            ends = np.concatenate([np.hstack([ends[:, :1], halves]), np.hstack([halves, ends[:, 1:]])])
            beside = np.concatenate([beside, beside])
        return Segments(ends, beside)

    def seams(self) -> Segments:
        """Seams of a net on the surface, and the adjacent drawn faces."""
        ends, beside = self.seams_in_space()
        placed = to_model(self.space, ends, WRITTEN)
        if not self.pieces.cuts:
            return Segments(placed, self.surface.surface.flat_faces.of_triangles[beside])
        corners = self.put(self.surface.vertices)[self.pieces.faces].mean(axis=1)
        own = beside[..., None] * self.pieces.per_face + np.arange(self.pieces.per_face)
        apart = np.linalg.norm(corners[own] - placed.mean(axis=1)[:, None, None], axis=3)
        return Segments(placed, np.take_along_axis(own, apart.argmin(axis=2)[..., None], axis=2)[..., 0])

    @property
    def _bend(self) -> float:
        """Largest distance of an edge piece's midpoint from its chord, in half diameters."""
        points, edges = self.points(self.surface.vertices), self.pieces.edges
        placed = to_model(self.space, points, WRITTEN)
        off = to_model(self.space, middles(self.space, points[edges]), WRITTEN) - placed[edges].mean(axis=1)
        size = np.linalg.norm(placed - placed.mean(axis=0), axis=1).max()
        return float(np.linalg.norm(off, axis=1).max() / size)


def space_name(space: Space) -> str:
    """Part of a caption: the space and the model of a picture; empty for R^3."""
    if space.is_euclidean:
        return ""
    model = "Poincaré ball" if space.curvature < 0 else "stereographic projection"
    return f"{space.name} space of curvature {space.curvature:.6g}, {model}"


def _center(space: Space, vertices: Floats) -> Floats:
    """Center of a surface; the origin if translating it would leave the drawable half of the sphere."""
    center = space.center(vertices)
    try:
        space.translated(vertices, -center)
    except InvalidParameter:
        return np.zeros(3)
    return center
