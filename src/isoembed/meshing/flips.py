"""Delaunay flips of a closed mesh in R^3, in rounds of independent edges; twins of its half-edges."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.meshing.loops import flip_halfedges, joined

SLACK = 1e-9  # radians: excess of two opposite angles over pi above which an edge is flipped


def twin_halfedges(faces: Indices) -> Indices:
    """Twins (3F,) of the half-edges; 3 f + c runs from faces[f, c] to faces[f, (c+1)%3].

    The mesh must be closed, oriented and simple.
    """
    n = int(faces.max()) + 1
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    twin = np.empty(faces.size, dtype=np.int64)
    twin[np.argsort(tail * n + head)] = np.argsort(head * n + tail)
    return twin


def corner_angles(vertices: Floats, faces: Indices) -> Floats:
    """Angles (F, 3) at the corners, in radians."""
    corners = vertices[faces]
    a, b = np.roll(corners, -1, axis=1) - corners, np.roll(corners, -2, axis=1) - corners
    normals = np.cross(a, b)
    return np.asarray(np.arctan2(np.sqrt((normals * normals).sum(axis=2)), (a * b).sum(axis=2)))


def flip_to_delaunay(
    vertices: Floats, normals: Floats, faces: Indices, twin: Indices
) -> tuple[Indices, Indices]:
    """Triangles (F, 3) and twins (3F,) after flips until no sum of opposite angles exceeds pi.

    Each round flips the worst edges that share no triangle. An edge is not flipped if the new one
    already exists, or if a new triangle would be oriented inward, by the outward normals at the vertices.
    """
    faces, twin = faces.copy(), twin.copy()
    flip_where_touched(vertices, normals, faces, twin, corner_angles(vertices, faces), np.arange(len(faces)))
    return faces, twin


def flip_where_touched(
    vertices: Floats, normals: Floats, faces: Indices, twin: Indices, angles: Floats, touched: Indices
) -> Indices:
    """Flip like `flip_to_delaunay`, but in place and starting from the touched triangles.

    Parameters
    ----------
    vertices, normals, faces, twin
        As in `flip_to_delaunay`.
    angles : (F, 3)
        The `corner_angles`, updated with the faces.
    touched : (k,)
        Triangles changed since the mesh was last Delaunay.

    Returns
    -------
    (m,)
        Flipped triangles, possibly repeated.
    """
    n, flips = len(vertices), [np.empty(0, dtype=np.int64)]
    for _ in range(200):  # a bent quadrilateral may flip forever
        is_touched = np.zeros(len(faces), dtype=bool)
        is_touched[touched] = True
        h = (3 * np.flatnonzero(is_touched)[:, None] + np.arange(3)).ravel()
        g = twin[h]
        h = np.sort(np.minimum(h, g)[(h < g) | ~is_touched[g // 3]])  # each edge once
        excess = _opposite(angles, h) + _opposite(angles, twin[h]) - np.pi
        bad, excess = h[excess > SLACK], excess[excess > SLACK]
        if bad.size == 0:
            break
        bad = bad[np.argsort(-excess, kind="stable")]
        flat, g = faces.ravel(), twin[bad]
        i, j = flat[bad], flat[g]
        k, m = flat[3 * (bad // 3) + (bad + 2) % 3], flat[3 * (g // 3) + (g + 2) % 3]
        touched = np.concatenate([bad // 3, g // 3])
        allowed = ~joined(flat, twin, 3 * (bad // 3) + (bad + 2) % 3, m)
        for a, b, c in ((k, i, m), (m, j, k)):
            area = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
            allowed &= np.einsum("ij,ij->i", area, normals[a] + normals[b] + normals[c]) > 0.0
        bad, key = bad[allowed], (np.minimum(k, m) * n + np.maximum(k, m))[allowed]
        if bad.size == 0:
            break
        # Worst first: an edge is flipped if it is first in both its triangles and among equal new edges.
        rank = np.arange(len(bad))
        first = np.full(len(faces), len(bad))
        np.minimum.at(first, bad // 3, rank)
        np.minimum.at(first, twin[bad] // 3, rank)
        chosen = (first[bad // 3] == rank) & (first[twin[bad] // 3] == rank)
        unique = np.zeros(len(bad), dtype=bool)
        unique[np.unique(key, return_index=True)[1]] = True
        flipped = bad[chosen & unique]
        changed = np.concatenate([flipped // 3, twin[flipped] // 3])
        flip_halfedges(faces, twin, flipped)
        angles[changed] = corner_angles(vertices, faces[changed])
        flips.append(changed)
    return np.concatenate(flips)


def _opposite(angles: Floats, h: Indices) -> Floats:
    """Angles opposite to half-edges."""
    return angles[h // 3, (h + 2) % 3]
