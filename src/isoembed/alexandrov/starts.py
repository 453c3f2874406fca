"""Initial radii of the homotopy."""

import math

import numpy as np

from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.metric.triangles import Triangles
from isoembed.space import Space

EPS = 2.0**-52


def equal_radii(tables: HalfEdges, ladder: tuple[float, ...]) -> list[float]:
    """Initial radii as multiples of the least one, over a Delaunay triangulation or an approximation of one.

    The polytope of equal radii R exists if R exceeds all circumradii of triangles; its curvatures sum to
    about ``4 pi - A / sn(R)^2``.
    """
    space = Space(tables.curvature)
    k = space.curvature
    triangles = Triangles.of(tables.face_lengths, k)
    chords = space.chord(tables.face_lengths)
    tangent = float((chords.prod(axis=1) / (2 * (triangles.amplitudes * triangles.unit**2))).max())
    sine = float(np.sqrt((triangles.areas * triangles.unit**2).sum() / (4 * np.pi)))
    if k > 0:  # sines are bounded by the radius of curvature: multiples of tangents
        smallest = max(tangent, sine / math.sqrt(max(1 - k * sine * sine, EPS)))
        return [math.atan(factor * smallest * space.root) / space.root for factor in ladder]
    # Circumradii of a Delaunay triangulation are finite, up to rounding.
    smallest = max(tangent / math.sqrt(max(1 + k * tangent * tangent, EPS)), sine)
    return [float(space.asn(factor * smallest)) for factor in ladder]
