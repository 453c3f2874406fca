"""One panel of a picture: a surface, its face values and a title."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.format import Polygons
from isoembed.plot.coloring import Quantity, face_means
from isoembed.plot.drawn import Drawn
from isoembed.reprs import short_repr
from isoembed.surface.segments import Segments


@short_repr
@dataclass(frozen=True, eq=False)
class Panel:
    """One surface of several in a row.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray of int, shape (F, 3), or sequence of such arrays of any lengths
        The vertices around each, counterclockwise, seen from outside.
    values : ndarray, shape (V,)
        What the colors show; of the faces, shape (F,), if the quantity is one of faces.
    title : str
    seams : Segments
        Lines that are drawn on the surface, beside these faces.
    at : {"vertices", "faces"}
        What the values are of.
    outlines : Segments or None
        Edges, where faces are drawn in pieces whose own are not to be seen.
    boundary : Segments
        Lines along the boundary of a surface.
    infinity : float
        The radius of the sphere at infinity about the origin.
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

    @classmethod
    def of(cls, drawn: Drawn, vertices: Floats, shown: Quantity) -> Panel:
        """A surface of vertices (V, 3), with its boundary, and the seams of a net on it."""
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
        )

    @property
    def face_values(self) -> Floats:
        """Values that the colors of the faces show, shape (F,)."""
        return self.values if self.at == "faces" else face_means(self.values, self.faces)
