"""Flat faces of a surface as planar polygons, with the gluing of their sides."""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.gluing.polygon import following, meeting_sides
from isoembed.intrinsic.plane import flattened
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.curvature import FLAT_ANGLE, dihedral_angles
from isoembed.surface.flat_faces import coplanar_faces, flat_faces, outlines
from isoembed.surface.measures import face_areas, face_normals


class Faces(NamedTuple):
    """Simple polygons, counterclockwise seen from outside, as tables of the concatenated sides.

    Attributes
    ----------
    first : ndarray of int, shape (n + 1,)
        Index of the first side of each face, followed by the number of sides.
    corners : ndarray of int, shape (S,)
        Start vertex of each side.
    points : ndarray, shape (S, 2)
        Position of the start vertex in the plane of the face.
    twins : ndarray of int, shape (S,)
        Side glued to each, in opposite direction; itself on a boundary.
    angles : ndarray, shape (S,)
        Exterior dihedral angle at each side: positive where the surface is convex, 0 where it is flat.
    """

    first: Indices
    corners: Indices
    points: Floats
    twins: Indices
    angles: Floats

    @property
    def following(self) -> Indices:
        """Next side around the face of each side, shape (S,)."""
        return following(self.first)

    @property
    def ends(self) -> Indices:
        """End vertex of each side, shape (S,)."""
        return self.corners[self.following]


def true_faces(triangulation: Triangulation, vertices: Floats, error: float = 0.0) -> Faces:
    """Polygonal faces of a surface: coplanar triangles are joined, and so are collinear sides.

    Faces with holes or self-intersecting outlines stay divided into triangles.  Every boundary vertex is a
    corner.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
        Scaled to prevent underflow and overflow.
    error : float, optional
        Error of each vertex, as in `coplanar_faces`.

    Raises
    ------
    InvalidMetric
        A face is so thin that its plane is undefined.
    """
    t = triangulation
    across = np.where(t.sides_across < 0, np.arange(t.faces.size), t.sides_across)
    thin = ~(face_areas(t.faces, vertices) > 0)
    if thin.any():
        f = int(np.argmax(thin))
        raise InvalidMetric(f"face {f} {t.faces[f].tolist()} is too thin to define a plane")
    faces = coplanar_faces(t, vertices, error=error)
    creased = (np.repeat(faces, 3) != faces[across // 3]) | (t.sides_across < 0)
    bend = np.where(creased, dihedral_angles(t, vertices)[t.face_edges.ravel()], 0.0)
    creased |= np.repeat(_no_polygons(t, vertices, creased, faces)[faces], 3)
    faces, ways = flat_faces(t, creased), outlines(t, creased)
    start, upward = t.faces.ravel(), _upward(t, vertices, faces)
    straight = _straight(t, vertices, creased, error)
    for way in ways:
        if (~straight[start[way]]).sum() < 3:  # slivers are not simplified
            straight[start[way]] = False
    sides: list[int] = []
    first, last, points = [0], [], []
    for way in ways:
        corners = [k for k, h in enumerate(way) if not straight[start[h]]]
        sides += [way[k] for k in corners]
        last += [way[k - 1] for k in (*corners[1:], corners[0])]
        first.append(len(sides))
        around = vertices[start[sides[first[-2] :]]]
        points.append(flattened(around - around[0], upward[faces[way[0] // 3]]))
    number = np.full(start.size, -1)
    number[sides] = np.arange(len(sides))
    return Faces(np.array(first), start[sides], np.concatenate(points), number[across[last]], bend[sides])


def _no_polygons(t: Triangulation, vertices: Floats, creased: Mask, faces: Indices) -> Mask:
    """Mask of faces that have holes or a self-intersecting outline."""
    start, upward, ways = t.faces.ravel(), _upward(t, vertices, faces), outlines(t, creased)
    owners = np.array([faces[way[0] // 3] for way in ways])
    wrong = np.bincount(owners, minlength=len(upward)) != 1
    for way, face in zip(ways, owners.tolist(), strict=True):
        if len(way) > 3:
            around = vertices[start[way]]
            flat = flattened(around - around[0], upward[face])
            size = np.ptp(flat, axis=0).max()
            wrong[face] |= meeting_sides((flat - flat.min(axis=0)) / size)[0] >= 0
    return wrong


def _upward(t: Triangulation, vertices: Floats, faces: Indices) -> Floats:
    """Vector areas of faces, times two."""
    normals = face_normals(t.faces, vertices)
    return np.column_stack([np.bincount(faces, normals[:, k]) for k in range(3)])


def _straight(t: Triangulation, vertices: Floats, creased: Mask, error: float) -> Mask:
    """Vertices at which exactly two, collinear creases end, shape (V,)."""
    start, end = t.faces.ravel(), np.roll(t.faces, -1, axis=1).ravel()
    rim = np.flatnonzero(creased)
    rim = rim[np.argsort(start[rim], kind="stable")]
    passed = (np.bincount(start[rim], minlength=t.n_vertices) == 2) & ~t.boundary_vertices
    pairs = end[rim[passed[start[rim]]]].reshape(-1, 2)
    here = np.flatnonzero(passed)
    to, onward = vertices[here] - vertices[pairs[:, 0]], vertices[pairs[:, 1]] - vertices[here]
    turned = np.arctan2(np.linalg.norm(np.cross(to, onward), axis=1), (to * onward).sum(axis=1))
    straight = np.zeros(t.n_vertices, dtype=np.bool_)
    doubt = 2 * error * (1 / np.linalg.norm(to, axis=1) + 1 / np.linalg.norm(onward, axis=1))
    straight[here[turned <= FLAT_ANGLE + doubt]] = True
    return straight
