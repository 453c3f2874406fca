"""Delaunay flips of a closed triangle mesh in R^3, in rounds of flips that do not touch each other."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SLACK = 1e-9
"""Radians by which two opposite angles must exceed pi: a cocircular pair is left alone."""


def twin_halfedges(faces: Index) -> Index:
    """Return the half-edge (3F,) that runs the other way; 3 f + c runs from faces[f, c] to faces[f, (c+1)%3].

    The mesh must be closed, oriented and simple.
    """
    n = int(faces.max()) + 1
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    twin = np.empty(faces.size, dtype=np.int64)
    twin[np.argsort(tail * n + head)] = np.argsort(head * n + tail)
    return twin


def corner_angles(vertices: Array, faces: Index) -> Array:
    """Return the angles (F, 3) at the corners, in radians."""
    x = vertices[faces]
    a, b = np.roll(x, -1, axis=1) - x, np.roll(x, -2, axis=1) - x
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=2), np.einsum("fci,fci->fc", a, b))


def _flip(faces: Index, twin: Index, h: Index) -> None:
    """Flip the half-edges h, no two of which share a triangle, in place."""
    g = twin[h]
    f, c, e, d = h // 3, h % 3, g // 3, g % 3
    i, j, k, m = faces[f, c], faces[f, (c + 1) % 3], faces[f, (c + 2) % 3], faces[e, (d + 2) % 3]
    old = np.concatenate([3 * f + (c + 2) % 3, 3 * e + (d + 1) % 3, 3 * e + (d + 2) % 3, 3 * f + (c + 1) % 3])
    new = np.concatenate([3 * f, 3 * f + 1, 3 * e, 3 * e + 1])
    # Neighboring quadrilaterals may be flipped in the same round: their half-edges move as well.
    moved_to = np.arange(len(twin))
    moved_to[old] = new
    across = moved_to[twin[old]]
    twin[new], twin[across] = across, new
    twin[3 * f + 2], twin[3 * e + 2] = 3 * e + 2, 3 * f + 2
    faces[f] = np.stack([k, i, m], axis=1)
    faces[e] = np.stack([m, j, k], axis=1)


def flip_to_delaunay(
    vertices: Array, normals: Array, faces: Index, twin: Index, max_rounds: int = 200
) -> tuple[Index, Index]:
    """Flip edges until no pair of opposite angles exceeds pi.

    Each round flips the worst edges that share no triangle. An edge is not flipped where the new one
    exists already, or where a new triangle would look inward.

    Parameters
    ----------
    vertices, normals : (V, 3)
        The points of the mesh and the outward normals of the surface there.
    faces : (F, 3)
    twin : (3F,)
        From :func:`twin_halfedges`.
    max_rounds
        In R^3 the angles of a bent quadrilateral can ask for either diagonal in turn; the rounds end then.

    Returns
    -------
    faces, twin
        New arrays.
    """
    faces, twin, n = faces.copy(), twin.copy(), len(vertices)
    for _ in range(max_rounds):
        opposite = np.roll(corner_angles(vertices, faces), -2, axis=1).ravel()
        excess = opposite + opposite[twin] - np.pi
        bad = np.flatnonzero((excess > SLACK) & (np.arange(len(twin)) < twin))
        if bad.size == 0:
            break
        bad = bad[np.argsort(-excess[bad], kind="stable")]
        flat, g = faces.ravel(), twin[bad]
        i, j = flat[bad], flat[g]
        k, m = flat[3 * (bad // 3) + (bad + 2) % 3], flat[3 * (g // 3) + (g + 2) % 3]
        tail, head = flat, np.roll(faces, -1, axis=1).ravel()
        allowed = ~np.isin(k * n + m, tail * n + head)
        for a, b, c in ((k, i, m), (m, j, k)):
            area = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
            allowed &= np.einsum("ij,ij->i", area, normals[a] + normals[b] + normals[c]) > 0.0
        bad, key = bad[allowed], (np.minimum(k, m) * n + np.maximum(k, m))[allowed]
        if bad.size == 0:
            break
        # Worst first: an edge goes if it comes first in both its triangles and among equal new edges.
        rank = np.arange(len(bad))
        first = np.full(len(faces), len(bad))
        np.minimum.at(first, bad // 3, rank)
        np.minimum.at(first, twin[bad] // 3, rank)
        chosen = (first[bad // 3] == rank) & (first[twin[bad] // 3] == rank)
        unique = np.zeros(len(bad), dtype=bool)
        unique[np.unique(key, return_index=True)[1]] = True
        _flip(faces, twin, bad[chosen & unique])
    return faces, twin
