"""Edges of a triangulated sphere in linear time; `checks` says what is wrong with other triangles."""

import numpy as np

from isoembed.arrays import Indices, Indices32, Mask
from isoembed.kernel import kernel

MOST = 2**31 - 1  # half-edges whose numbers fit into 32 bits


def join(faces: Indices) -> tuple[Indices, Indices, Indices] | None:
    """Edges, and which half-edges run along them, if the faces are a triangulated sphere.

    Returned are edges, face_edges and edge_halfedges, as in `Triangulation`; or None if the faces, whose
    vertices are not negative, are anything but a triangulated sphere.
    """
    corners = faces.ravel()
    n = int(corners.max()) + 1
    if corners.size > MOST or n - len(faces) / 2 != 2:
        return None
    edges, halfedges = np.empty((corners.size // 2, 2), np.int64), np.empty((corners.size // 2, 2), np.int64)
    face_edges, twins = np.empty(faces.shape, np.int64), np.empty(corners.size, np.int32)
    if not _pair(corners, _sorted_by_ends(corners, n), edges, face_edges.ravel(), halfedges, twins):
        return None
    # A connected surface has V' - E + F <= 2, where V' counts a vertex once for each fan of faces around it.
    # If all n vertices are in faces, n <= V'; as n - E + F = 2, there is one fan around each, and no handle.
    is_sphere = np.bincount(corners, minlength=n).all() and reached_faces(twins).all()
    return (edges, face_edges, halfedges) if is_sphere else None


@kernel
def _next(h: int) -> int:
    return h - 2 if h % 3 == 2 else h + 1


@kernel
def _sorted_by_ends(corners: Indices, n: int) -> Indices32:
    """The half-edges by their lower and then by their higher end: two passes of counting."""
    before, after = np.arange(corners.size).astype(np.int32), np.empty(corners.size, dtype=np.int32)
    for lower in (False, True):
        starts = np.zeros(n + 1, dtype=np.int32)
        for h in range(corners.size):
            a, b = corners[h], corners[_next(h)]
            starts[(min(a, b) if lower else max(a, b)) + 1] += 1
        for v in range(n):
            starts[v + 1] += starts[v]
        for k in range(corners.size):
            h = before[k]
            a, b = corners[h], corners[_next(h)]
            v = min(a, b) if lower else max(a, b)
            after[starts[v]] = h
            starts[v] += 1
        before, after = after, before
    return before


@kernel
def _pair(
    corners: Indices,
    order: Indices32,
    edges: Indices,
    face_edges: Indices,
    edge_halfedges: Indices,
    twins: Indices32,
) -> bool:
    """Fill in the tables; False if half-edges do not come in pairs that run in opposite directions."""
    for e in range(len(edges)):
        h, g = order[2 * e], order[2 * e + 1]
        a, b = corners[h], corners[_next(h)]
        if a == b or corners[_next(g)] != a:
            return False
        if a > b:
            h, g, a, b = g, h, b, a
        if e and edges[e - 1, 0] == a and edges[e - 1, 1] == b:
            return False
        edges[e, 0], edges[e, 1] = a, b
        edge_halfedges[e, 0], edge_halfedges[e, 1] = h, g
        face_edges[h], face_edges[g] = e, e
        twins[h], twins[g] = g, h
    return True


@kernel
def reached_faces(twins: Indices | Indices32) -> Mask:
    """Whether one gets from the first face to each face across edges, shape (F,), given their half-edges."""
    n_faces = len(twins) // 3
    reached, stack = np.zeros(n_faces, dtype=np.bool_), np.empty(n_faces, dtype=np.int32)
    reached[0], stack[0], waiting = True, 0, 1
    while waiting:
        waiting -= 1
        f = stack[waiting]
        for h in range(3 * f, 3 * f + 3):
            g = twins[h] // 3
            if not reached[g]:
                reached[g] = True
                stack[waiting] = g
                waiting += 1
    return reached
