"""Removal of flat vertices from an intrinsic triangulation.

The triangles around a vertex without curvature unfold into a polygon in the plane, which is retriangulated by
diagonals.  Loops are flipped away first, except one around the only neighbor of a vertex of small angle.
Vertices are removed in rounds of pairwise nonadjacent vertices, so that the position of a vertex is given
relative to a neighbor that is removed in a later round or stays.  The number of steps to recover a position
thus grows with the logarithm of the number of vertices (D. Kirkpatrick, Optimal search in planar
subdivisions, SIAM J. Comput. 12, 1983).
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.removal_loops import remove_vertices
from isoembed.mesh.triangulation import frozen


class Removal(NamedTuple):
    """Removed vertices and their positions.

    Attributes
    ----------
    core : ndarray of int, shape (V,)
        Original indices of the remaining vertices, ascending.
    removed : ndarray of int, shape (n,)
        Original indices of the removed vertices, in order of removal.
    anchors : ndarray of int, shape (n,)
        Original index of a neighbor present at the time of removal.
    directions : ndarray, shape (n,)
        Direction at the anchor toward the vertex.
    distances : ndarray, shape (n,)
        Length of the geodesic from the anchor in that direction to the vertex.
    backs : ndarray, shape (n,)
        Direction at the vertex toward the anchor.
    """

    core: Indices
    removed: Indices
    anchors: Indices
    directions: Floats
    distances: Floats
    backs: Floats


def remove_flat_vertices(mesh: HalfEdges, flat: Mask) -> tuple[HalfEdges, Removal]:
    """Remove flat vertices from a triangulation.

    Parameters
    ----------
    mesh : HalfEdges
    flat : ndarray of bool, shape (V,)
        Vertices with total angle 2 pi up to rounding.  At least three others must remain.

    Returns
    -------
    HalfEdges
        Delaunay triangulation of the same metric on the other vertices, renumbered in order, with unchanged
        reference directions.
    Removal
        Positions of the removed vertices.

    Raises
    ------
    InvalidMetric
        The triangles at a vertex are too thin to be laid out in floats.
    """
    mesh = mesh.copy()
    make_delaunay(mesh, np.zeros(flat.size))
    n = int(flat.sum())
    core = np.flatnonzero(~flat)
    removal = Removal(core, *np.empty((2, n), dtype=np.int64), *np.empty((3, n)))
    alive, count = remove_vertices(mesh.views, flat, removal)
    if count < n:
        v = int(np.setdiff1d(np.flatnonzero(flat), removal.removed[:count])[0])
        raise InvalidMetric(
            f"vertex {v} is flat, but the triangles around it are so thin that rounding hides how they lie"
        )
    left = mesh.of_faces(np.flatnonzero(alive))
    number = np.cumsum(~flat) - 1
    return left._replace(corners=number[left.corners]), Removal._make(frozen(table) for table in removal)
