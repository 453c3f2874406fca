"""Tetrahedra from six lengths.

Four cone points have many triangulations, including that of the tetrahedron.  It is searched by flips
from the Delaunay triangulation: any tetrahedron found is a convex body, which is unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.alexandrov.lengths import worst_length
from isoembed.arrays import Floats
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip

FLAT = 1e-5  # in longest edges: a lower body may be a polygon up to rounding


@dataclass(frozen=True, eq=False)
class Tetrahedron:
    """Body with four vertices.

    Attributes
    ----------
    tables : HalfEdges
    vertices : ndarray, shape (4, 3)
    """

    tables: HalfEdges
    vertices: Floats


def tetrahedron(core: HalfEdges) -> Tetrahedron | None:
    """Find the body of a metric on four vertices; None if it is flat, many flips away, or not in R^3."""
    if core.curvature != 0:
        return None
    first = core.copy()
    make_delaunay(first, np.zeros(4))
    layer = [first]
    for _ in range(3 + 1):  # from the Delaunay triangulation to that of the tetrahedron
        for tables in layer:
            vertices = _placed(tables)
            if vertices is not None and worst_length(tables, vertices) <= 1e-13:  # mean edge lengths
                return Tetrahedron(tables, vertices)
        layer = [after for tables in layer for after in _flipped(tables)]
    return None


def _flipped(tables: HalfEdges) -> list[HalfEdges]:
    """All triangulations one flip away."""
    found = []
    for h in tables.edges.tolist():
        after = tables.copy()
        if flip(h, after.views, 1e-3):  # in longest sides: thinner triangles lose digits
            found.append(after)
    return found


def _placed(tables: HalfEdges) -> Floats | None:
    """Vertices (4, 3) with the lengths of four triangles; None if two edges join the same vertices."""
    lengths = np.zeros((4, 4))
    i, j = tables.ends
    lengths[i, j] = tables.lengths
    if (i == j).any() or np.count_nonzero(lengths) < 12:
        return None
    a, b, c, d = lengths[0, 1], lengths[0, 2], lengths[1, 2], lengths[:, 3]
    x = (a * a + (b - c) * (b + c)) / (2 * a)
    y = np.sqrt(max((b - x) * (b + x), 0.0))
    if not y > FLAT * lengths.max():
        return None
    u = (a * a + (d[0] - d[1]) * (d[0] + d[1])) / (2 * a)
    v = ((d[0] - d[2]) * (d[0] + d[2]) + x * (x - 2 * u) + y * y) / (2 * y)
    square = (d[0] - u) * (d[0] + u) - v * v
    if not square > (FLAT * lengths.max()) ** 2:
        return None
    return np.array([[0, 0, 0], [a, 0, 0], [x, y, 0], [u, v, np.sqrt(square)]])
