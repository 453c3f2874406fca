"""Surfaces of hyperbolic and spherical space in a conformal model, for drawing.

Hyperbolic space is drawn as Poincare's ball, spherical space in stereographic projection.  Straight edges are
arcs of circles there, and plane faces parts of spheres: large ones are drawn in pieces.
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
from isoembed.space import Space
from isoembed.space.models import radius_of, to_model
from isoembed.surface.segments import Segments

MAX_BEND = 1e-3  # half diameters by which a straight piece of an edge may miss the arc
MAX_PIECES = 20_000  # with more pieces there is no further subdivision
BALL_RADIUS = 6.0  # half diameters beyond which the sphere at infinity is out of the picture


@dataclass(frozen=True, eq=False)
class Drawn:
    """Drawing of a surface, and of others with the same triangles.

    Attributes
    ----------
    surface : Embedding
    center : ndarray, shape (3,)
        The point of space that is moved to the origin.
    pieces : Pieces
        The triangles, in pieces where one would see that they are straight.
    """

    surface: Embedding
    center: Floats
    pieces: Pieces

    @classmethod
    def of(cls, surface: Embedding) -> Drawn:
        """A surface in R^3 is drawn as it is."""
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
        """The radius of the sphere at infinity about the origin of a picture; infinite if there is none."""
        return radius_of(self.space, WRITTEN) if self.space.curvature < 0 else np.inf

    @property
    def faces(self) -> Polygons:
        """Faces of the drawing: those of the surface, or the pieces of its triangles."""
        return self.pieces.faces if self.pieces.cuts else self.surface.polygons

    def points(self, vertices: Floats) -> Floats:
        """Points of space at all vertices that are drawn, for those (V, 3) of a surface."""
        if self.space.is_euclidean:
            return vertices
        return self.pieces.points(self.space, self.space.translated(vertices, -self.center))

    def put(self, vertices: Floats) -> Floats:
        """Positions in a picture of the vertices of the drawing, for those (V, 3) of a surface."""
        return to_model(self.space, self.points(vertices), WRITTEN)

    def face_values(self, shown: Quantity) -> Floats:
        """Values of what is drawn: each face has one, that of its pieces."""
        faces, pieces = self.surface.surface.flat_faces, self.pieces
        values = shown.values if shown.at == "faces" else face_means(shown.values, faces.polygons)
        return np.repeat(values[faces.of_triangles], pieces.per_face) if pieces.cuts else values

    def spread(self, shown: Quantity) -> Quantity:
        """A quantity at all vertices that are drawn; one of faces as it is."""
        if shown.at == "faces":
            return shown
        return replace(shown, values=self.pieces.values(shown.values))

    def outlines(self, placed: Floats) -> Segments | None:
        """The edges between faces as `put` has placed them; None where the outlines of faces are those."""
        if not self.pieces.cuts:
            return None
        between = self.surface.surface.flat_faces.edges[self.pieces.owners]
        return Segments(placed[self.pieces.edges[between]], self.pieces.beside()[between])

    def boundary(self, placed: Floats) -> Segments:
        """The edges on the boundary of a surface in R^3 as `put` has placed them."""
        t = self.surface.triangulation
        beside = self.surface.surface.flat_faces.of_triangles[t.edge_flanks[t.boundary_edges] // 3]
        return Segments(placed[t.edges[t.boundary_edges]], beside)

    def seams_in_space(self) -> Segments:
        """The seams of a net in pieces, between points of space, and the triangles beside them."""
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
        """The seams of a net on the surface, and the faces that are drawn beside them."""
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
        """Distance of the middle of a piece of an edge from the line between its ends, in half diameters."""
        points, edges = self.points(self.surface.vertices), self.pieces.edges
        placed = to_model(self.space, points, WRITTEN)
        off = to_model(self.space, middles(self.space, points[edges]), WRITTEN) - placed[edges].mean(axis=1)
        size = np.linalg.norm(placed - placed.mean(axis=0), axis=1).max()
        return float(np.linalg.norm(off, axis=1).max() / size)


def said(space: Space) -> str:
    """Part of a caption: which space a picture shows, and in which model; nothing of R^3."""
    if space.is_euclidean:
        return ""
    model = "Poincaré ball" if space.curvature < 0 else "stereographic projection"
    return f"{space.name} space of curvature {space.curvature:.6g}, {model}"


def _center(space: Space, vertices: Floats) -> Floats:
    """The center of a surface, or the origin where on the sphere that leaves it more than half of it wide."""
    center = space.center(vertices)
    try:
        space.translated(vertices, -center)
    except InvalidParameter:
        return np.zeros(3)
    return center
