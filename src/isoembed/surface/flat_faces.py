"""Flat faces of a triangulated surface: triangles joined where no crease is between them."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import FLAT_ANGLE, bend_errors, dihedral_angles, turning_errors
from isoembed.surface.measures import face_normals


def outlines(triangulation: Triangulation, creased: Mask) -> list[list[int]]:
    """Closed ways around the faces that creases bound.

    Parameters
    ----------
    triangulation : Triangulation
    creased : ndarray of bool, shape (3F,)
        The half-edges on creases; with each its twin.

    Returns
    -------
    list of list of int
        The half-edges of each way, one after the other, with the face to their left.  A face with holes has
        several.
    """
    t = triangulation
    halfedge = np.arange(t.faces.size)
    following = halfedge + np.where(halfedge % 3 == 2, -2, 1)
    # At the end of a half-edge of an outline, turn around to the next: past all edges that are flat.
    rim = np.flatnonzero(creased)
    successor = following.copy()
    while (inside := rim[~creased[successor[rim]]]).size:
        successor[inside] = following[t.twins[successor[inside]]]
    after, seen = successor.tolist(), ~creased
    ways = []
    for h in rim.tolist():
        way = []
        while not seen[h]:
            seen[h] = True
            way.append(h)
            h = after[h]
        if way:
            ways.append(way)
    return ways


def flat_faces(triangulation: Triangulation, creased: Mask) -> Indices:
    """The face that each triangle is part of, shape (F,), numbered in the order of their first triangles."""
    t = triangulation
    inside = np.flatnonzero(~creased)
    return components(inside // 3, t.twins[inside] // 3, t.n_faces)


def coplanar_faces(
    triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN, error: float = 0.0
) -> Indices:
    """The flat face that each triangle is part of, shape (F,).

    A triangle so low that rounding turns it joins the face to which it is bent least, but joins no two.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    space : Space, optional
    error : float, optional
        Bound on the error of a vertex, from coordinates that were rounded: triangles are one face where no
        bend between them is larger than its `bend_errors`, and all vertices are near one plane.
    """
    t = triangulation
    angles = np.abs(dihedral_angles(t, vertices, space))
    turned = turning_errors(t, vertices, space)
    flat = angles <= FLAT_ANGLE
    faces = flat_faces(t, ~flat[t.face_edges.ravel()])
    known = np.bincount(faces, turned <= FLAT_ANGLE) > 0  # by a triangle that is not as low
    doubtful = np.flatnonzero(~flat & (angles <= FLAT_ANGLE + turned[t.edge_faces].max(axis=1)))
    joined = np.arange(len(known))
    for e in doubtful[np.argsort(angles[doubtful], kind="stable")].tolist():
        one, other = joined[faces[t.edge_faces[e]]]
        if one != other and not (known[one] and known[other]):
            known[one] |= known[other]
            joined[joined == other] = one
    found = np.unique(joined[faces], return_inverse=True)[1]
    if error:
        bent = angles > FLAT_ANGLE + bend_errors(t, vertices, space, error)
        wide = flat_faces(t, bent[t.face_edges.ravel()])
        # Many small bends may lead around a surface that is smooth: that is no face.
        curved = _heights(t, vertices, wide) > 2 * error
        found = np.unique(np.where(curved, len(faces) + found, wide), return_inverse=True)[1]
    return found if found.any() else faces  # of a needle all is doubtful, and a closed surface is no face


def _heights(t: Triangulation, vertices: Floats, faces: Indices) -> Floats:
    """For each triangle, how far the vertices of its face are from the plane of the face, shape (F,)."""
    normals = np.column_stack([np.bincount(faces, n) for n in face_normals(t.faces, vertices).T])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.maximum(sizes, np.finfo(np.float64).tiny)
    offsets = np.einsum("fci,fi->fc", vertices[t.faces], normals[faces])
    lowest, highest = np.full(len(normals), np.inf), np.full(len(normals), -np.inf)
    np.minimum.at(lowest, faces, offsets.min(axis=1))
    np.maximum.at(highest, faces, offsets.max(axis=1))
    return (highest - lowest)[faces] / 2
