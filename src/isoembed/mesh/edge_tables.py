"""Edges of a triangulated sphere, their half-edges and the edges of faces, in linear time."""

import numpy as np

from isoembed.arrays import Indices
from isoembed.mesh.loops import pair, reached_faces, sorted_by_ends

MOST = 2**31 - 1  # half-edges whose numbers fit into 32 bits


def edge_tables(faces: Indices) -> tuple[Indices, Indices, Indices] | None:
    """Tables of the edges if the faces are a triangulated sphere.

    Returns edges, face_edges and edge_halfedges, as in `Triangulation`, or None if the faces, whose vertices
    must be nonnegative, are not a triangulated sphere.
    """
    corners = faces.ravel()
    n = int(corners.max()) + 1
    if corners.size > MOST or n - len(faces) / 2 != 2:
        return None
    edges, halfedges = np.empty((corners.size // 2, 2), np.int64), np.empty((corners.size // 2, 2), np.int64)
    face_edges, twins = np.empty(faces.shape, np.int64), np.empty(corners.size, np.int32)
    if not pair(corners, sorted_by_ends(corners, n), edges, face_edges.ravel(), halfedges, twins):
        return None
    # A connected surface has V' - E + F <= 2, where V' counts a vertex once for each fan of faces around it.
    # If all n vertices are in faces, n <= V'; as n - E + F = 2, each has one fan, and there is no handle.
    is_sphere = np.bincount(corners, minlength=n).all() and reached_faces(twins).all()
    return (edges, face_edges, halfedges) if is_sphere else None
