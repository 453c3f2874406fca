"""Polygonal faces: coplanar triangles merged."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.reprs import short_repr
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import FLAT_ANGLE, bend_errors, dihedral_angles, turning_errors
from isoembed.surface.measures import edge_lengths, face_normals


@short_repr
@dataclass(frozen=True, eq=False)
class TriangleFaces:
    """Triangular faces.

    Attributes
    ----------
    triangulation : Triangulation
    of_triangles : ndarray of int, shape (F,)
        Face containing each triangle.
    """

    triangulation: Triangulation
    of_triangles: Indices

    @property
    def polygons(self) -> Indices | Sequence[Indices]:
        """Vertices of each face, counterclockwise as seen from outside."""
        return self.triangulation.faces

    @property
    def sides(self) -> Indices:
        """Number of sides of each face."""
        return frozen(np.full(len(self.triangulation.faces), 3))

    @property
    def edges(self) -> Mask:
        """Edges between two faces, shape (E,): the others are diagonals, which are arbitrary."""
        return frozen(np.ones(self.triangulation.n_edges, dtype=np.bool_))

    def __len__(self) -> int:
        return len(self.polygons)


@short_repr
@dataclass(frozen=True, eq=False)
class FlatFaces(TriangleFaces):
    """Faces of a convex polyhedron, each of one or more coplanar triangles.

    Triangles belong to the same face if the dihedral angle between them is below 1e-7 radians.  Slivers that
    rounding may rotate by more join the neighboring face with the smallest dihedral angle.  If the lengths
    have errors or come from rounded coordinates, angles within their effect do not count either.

    Attributes
    ----------
    triangulation, of_triangles
        As of `TriangleFaces`.
    lengths : ndarray, shape (E,)
        Lengths of the edges of the triangles, in the `unit` of the surface.
    flat : ndarray of bool, shape (V,)
        Vertices inside faces and edges.
    """

    lengths: Floats
    flat: Mask

    @classmethod
    def of(
        cls, triangulation: Triangulation, vertices: Floats, space: Space, error: float, flat: Mask
    ) -> Self:
        """Faces of a convex polyhedron.

        Parameters
        ----------
        triangulation : Triangulation
        vertices : ndarray, shape (V, 3)
        space : Space
        error : float
            Error of the vertices from rounded coordinates or lengths.
        flat : ndarray of bool, shape (V,)
        """
        faces = frozen(coplanar_faces(triangulation, vertices, space, error))
        lengths = frozen(edge_lengths(triangulation.edges, vertices, space))
        return cls(triangulation, faces, lengths, flat)

    @cached_property
    def polygons(self) -> tuple[Indices, ...]:
        """Vertices around each face, counterclockwise as seen from outside.

        Flat vertices on an edge of the polyhedron are included, those inside a face are not.
        """
        t = self.triangulation
        start, faces = t.faces.ravel(), self.of_triangles
        polygons: list[Indices] = [np.zeros(0, dtype=np.int64)] * (int(faces.max()) + 1)
        lengths = self.lengths[t.face_edges.ravel()]
        ways = outlines(t, self.edges[t.face_edges.ravel()])
        for way in sorted(ways, key=lambda way: float(lengths[way].sum())):  # holes first
            polygons[faces[way[0] // 3]] = frozen(start[way])
        return tuple(polygons)

    @cached_property
    def sides(self) -> Indices:
        """Number of sides of each face, not counting flat vertices on its outline."""
        flat = self.flat[np.concatenate(self.polygons)]
        ends = np.cumsum([len(polygon) for polygon in self.polygons])
        return frozen(np.diff(np.cumsum(~flat)[ends - 1], prepend=0).astype(np.int64))

    @cached_property
    def edges(self) -> Mask:
        """Edges between two faces, shape (E,): the others are diagonals, which are arbitrary."""
        left, right = self.of_triangles[self.triangulation.edge_flanks // 3].T
        return frozen((left != right) | self.triangulation.boundary_edges)

    def __len__(self) -> int:
        return int(self.of_triangles.max()) + 1

    def vertex_shares(self, areas: Floats) -> Floats:
        """Vertex areas, (V,), from the areas of the triangles, (F,).

        Each face's area is divided equally among its vertices, independently of its diagonals.
        """
        whole = np.bincount(self.of_triangles, areas)
        polygon = np.repeat(self.of_triangles, 3)
        polygon, vertex = np.unique(np.column_stack([polygon, self.triangulation.faces.ravel()]), axis=0).T
        shares = whole / np.bincount(polygon)
        return np.bincount(vertex, shares[polygon]).astype(np.float64)


def outlines(triangulation: Triangulation, creased: Mask) -> list[list[int]]:
    """Boundary cycles of the faces bounded by creases.

    Parameters
    ----------
    triangulation : Triangulation
    creased : ndarray of bool, shape (3F,)
        Half-edges on creases, closed under twins and including those on the boundary.

    Returns
    -------
    list of list of int
        Consecutive half-edges of each cycle, with the face to their left.  A face with holes has several.
    """
    t = triangulation
    halfedge = np.arange(t.faces.size)
    following = halfedge + np.where(halfedge % 3 == 2, -2, 1)
    # At the end of a half-edge of an outline, rotate past all flat edges to the next one.
    rim = np.flatnonzero(creased)
    successor = following.copy()
    while (inside := rim[~creased[successor[rim]]]).size:
        successor[inside] = following[t.sides_across[successor[inside]]]
    after, visited = successor.tolist(), ~creased
    ways = []
    for h in rim.tolist():
        way = []
        while not visited[h]:
            visited[h] = True
            way.append(h)
            h = after[h]
        if way:
            ways.append(way)
    return ways


def flat_faces(triangulation: Triangulation, creased: Mask) -> Indices:
    """Face containing each triangle, shape (F,), numbered in the order of the faces' first triangles.

    The creases are as in `outlines`.
    """
    t = triangulation
    inside = np.flatnonzero(~creased)
    return components(inside // 3, t.sides_across[inside] // 3, t.n_faces)


def coplanar_faces(
    triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN, error: float = 0.0
) -> Indices:
    """Flat face containing each triangle, shape (F,).

    A sliver that rounding may rotate joins the face with the smallest dihedral angle, but never merges two.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    space : Space, optional
    error : float, optional
        Bound on the error of a vertex from rounded coordinates: triangles form one face if no dihedral angle
        between them exceeds its `bend_errors`, and all vertices are near one plane.
    """
    t = triangulation
    angles = np.abs(dihedral_angles(t, vertices, space))
    turned = turning_errors(t, vertices, space)
    flat, flanks = (angles <= FLAT_ANGLE) & ~t.boundary_edges, t.edge_flanks // 3
    faces = flat_faces(t, ~flat[t.face_edges.ravel()])
    has_normal = np.bincount(faces, turned <= FLAT_ANGLE) > 0  # faces with a triangle that is not a sliver
    doubtful = np.flatnonzero(~flat & (angles <= FLAT_ANGLE + turned[flanks].max(axis=1)))
    joined = np.arange(len(has_normal))
    for e in doubtful[np.argsort(angles[doubtful], kind="stable")].tolist():
        one, other = joined[faces[flanks[e]]]
        if one != other and not (has_normal[one] and has_normal[other]):
            has_normal[one] |= has_normal[other]
            joined[joined == other] = one
    found = np.unique(joined[faces], return_inverse=True)[1]
    if error:
        bent = (angles > FLAT_ANGLE + bend_errors(t, vertices, space, error)) | t.boundary_edges
        wide = flat_faces(t, bent[t.face_edges.ravel()])
        # Many small bends may add up on a smooth surface, which is not a face.
        curved = _heights(t, vertices, wide) > 2 * error
        found = np.unique(np.where(curved, len(faces) + found, wide), return_inverse=True)[1]
    return found if found.any() else faces  # a needle is all slivers, and a closed surface is not one face


def _heights(t: Triangulation, vertices: Floats, faces: Indices) -> Floats:
    """Half the extent of each triangle's face perpendicular to its plane, shape (F,)."""
    normals = np.column_stack([np.bincount(faces, n) for n in face_normals(t.faces, vertices).T])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.maximum(sizes, np.finfo(np.float64).tiny)
    offsets = np.einsum("fci,fi->fc", vertices[t.faces], normals[faces])
    lowest, highest = np.full(len(normals), np.inf), np.full(len(normals), -np.inf)
    np.minimum.at(lowest, faces, offsets.min(axis=1))
    np.maximum.at(highest, faces, offsets.max(axis=1))
    return (highest - lowest)[faces] / 2
