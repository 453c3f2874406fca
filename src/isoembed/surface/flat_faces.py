"""Flat faces of a triangulated surface: triangles joined where no crease is between them."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import DIHEDRAL, dihedral_angles, turning_errors


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


def coplanar_faces(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Indices:
    """The flat face that each triangle is part of, shape (F,).

    A triangle so low that rounding turns it joins the face to which it is bent least, but joins no two.
    """
    t = triangulation
    angles = np.abs(dihedral_angles(t, vertices, space))
    errors = turning_errors(t, vertices, space)
    flat = angles <= DIHEDRAL.flat
    faces = flat_faces(t, ~flat[t.face_edges.ravel()])
    known = np.bincount(faces, errors <= DIHEDRAL.flat) > 0  # by a triangle that is not as low
    doubtful = np.flatnonzero(~flat & (angles <= DIHEDRAL.flat + errors[t.edge_faces].max(axis=1)))
    joined = np.arange(len(known))
    for e in doubtful[np.argsort(angles[doubtful], kind="stable")].tolist():
        one, other = joined[faces[t.edge_faces[e]]]
        if one != other and not (known[one] and known[other]):
            known[one] |= known[other]
            joined[joined == other] = one
    found = np.unique(joined[faces], return_inverse=True)[1]
    return found if found.any() else faces  # of a needle all is doubtful, and a closed surface is no face
