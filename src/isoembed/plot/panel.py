"""Panel of a picture: a surface, its face values and a title."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.format import Polygons
from isoembed.plot.coloring import Quantity, face_means
from isoembed.plot.curved_space import Drawn
from isoembed.plot.view import Pose
from isoembed.reprs import short_repr
from isoembed.surface.segments import Segments


@short_repr
@dataclass(frozen=True, eq=False)
class Panel:
    """A surface in a row of several.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray of int, shape (F, 3), or sequence of such arrays of any lengths
        Vertices around each face, counterclockwise seen from outside.
    values : ndarray, shape (V,)
        Displayed values; for a face quantity, shape (F,).
    title : str
    seams : Segments
        Lines drawn on the surface, with the adjacent faces.
    at : {"vertices", "faces"}
        Location of the values.
    outlines : Segments or None
        Edges to draw where faces are subdivided, instead of the outlines of the pieces.
    boundary : Segments
        Boundary edges of the surface.
    infinity : float
        Radius of the sphere at infinity about the origin.
    pose : Pose or None
        Pose in a picture; by default that of the vertices.
    """

    vertices: Floats
    faces: Polygons
    values: Floats
    title: str = ""
    seams: Segments = field(default_factory=Segments.none)
    at: Literal["vertices", "faces"] = "vertices"
    outlines: Segments | None = None
    boundary: Segments = field(default_factory=Segments.none)
    infinity: float = np.inf
    pose: Pose | None = None

    @classmethod
    def of(cls, drawn: Drawn, vertices: Floats, shown: Quantity) -> Panel:
        """Panel of a surface with vertices (V, 3), its boundary, and the seams of a net."""
        placed = drawn.put(vertices)
        cut = drawn.pieces.cuts > 0
        return cls(
            placed,
            drawn.faces,
            drawn.face_values(shown) if cut else shown.values,
            seams=drawn.seams(),
            at="faces" if cut else shown.at,
            outlines=drawn.outlines(placed),
            boundary=drawn.boundary(placed),
            infinity=drawn.infinity,
            pose=drawn.pose(vertices) if cut else None,
        )

    @property
    def face_values(self) -> Floats:
        """Values displayed on the faces, shape (F,)."""
        return self.values if self.at == "faces" else face_means(self.values, self.faces)
