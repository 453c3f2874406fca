"""Removal of flat vertices from an intrinsic triangulation.

The triangles around a vertex without curvature unfold into a polygon in the plane, which is cut anew along
diagonals.  Loops are flipped away first, except for one around the only neighbor of a vertex of small angle.
Vertices go in rounds, in each of which no two are neighbors, so that where a vertex was is known
from a neighbor that goes in a later round or stays: after a number of steps that grows with the logarithm
of the number of vertices (D. Kirkpatrick, Optimal search in planar subdivisions, SIAM J. Comput. 12, 1983).
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
    """Vertices that were removed, and their places.

    Attributes
    ----------
    core : ndarray of int, shape (V,)
        The old numbers of the vertices that are left, ascending.
    removed : ndarray of int, shape (n,)
        The old numbers of the others, in the order in which they went.
    anchors : ndarray of int, shape (n,)
        The old number of a neighbor that was still there.
    directions : ndarray, shape (n,)
        The direction at the anchor in which the vertex lay.
    distances : ndarray, shape (n,)
        Length of the straight line from the anchor in that direction to the vertex.
    backs : ndarray, shape (n,)
        The direction at the vertex in which that line came back.
    """

    core: Indices
    removed: Indices
    anchors: Indices
    directions: Floats
    distances: Floats
    backs: Floats


def remove_flat_vertices(mesh: HalfEdges, flat: Mask) -> tuple[HalfEdges, Removal]:
    """Take flat vertices out of a triangulation.

    Parameters
    ----------
    mesh : HalfEdges
    flat : ndarray of bool, shape (V,)
        Vertices of total angle 2 pi up to rounding.  At least three others remain.

    Returns
    -------
    HalfEdges
        A Delaunay triangulation of the same metric on the other vertices, which are renumbered in order; the
        directions are measured as before.
    Removal
        Where the removed vertices were.

    Raises
    ------
    InvalidMetric
        The triangles at a vertex are so thin that rounding hides how they lie.
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
