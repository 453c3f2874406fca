"""Frame of a surface: struts along bent and boundary edges, in their order around hubs and faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.flat_faces import coplanar_faces
from isoembed.surface.measures import face_normals
from isoembed.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class Frame:
    """Struts and hubs of a surface in R^3.

    Attributes
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    is_strut : ndarray of bool, shape (E,)
        Whether an edge is on the boundary, or between two triangles that are not coplanar.
    """

    triangulation: Triangulation
    vertices: Floats
    is_strut: Mask

    @classmethod
    def of(cls, surface: Surface) -> Frame:
        """Frame of a surface, in its normalized unit."""
        t, x = surface.triangulation, surface._normalized
        left, right = coplanar_faces(t, x, error=surface._vertex_error)[t.edge_flanks // 3].T
        return cls(t, x, t.boundary_edges | (left != right))

    def hubs(self) -> list[Indices]:
        """Struts at each vertex, counterclockwise seen from outside; empty at vertices without struts.

        At a boundary vertex the first and last struts are on the boundary.
        """
        t = self.triangulation
        edge_of, across = t.face_edges.ravel(), t.sides_across.tolist()
        leaving = np.empty(t.n_vertices, dtype=np.int64)
        leaving[t.faces.ravel()] = np.arange(t.faces.size)
        rim = np.flatnonzero(t.sides_across < 0)
        leaving[t.faces.ravel()[rim]] = rim  # all others follow it counterclockwise
        found = []
        for first in leaving.tolist():
            edges, h = [], first
            while True:
                edges.append(edge_of[h])
                entering = _before(h)
                h = across[entering]
                if h < 0:
                    edges.append(edge_of[entering])
                if h < 0 or h == first:
                    break
            around = np.array(edges)
            found.append(around[self.is_strut[around]])
        return found

    def outlines(self) -> list[Indices]:
        """Struts along each outline of a face; coplanar triangles form one face."""
        t = self.triangulation
        edge_of, across = t.face_edges.ravel(), t.sides_across.tolist()
        left = self.is_strut[edge_of]
        is_side = left.copy()
        found = []
        for h in np.flatnonzero(is_side).tolist():
            outline = []
            while left[h]:
                left[h] = False
                outline.append(edge_of[h])
                h = _after(h)
                while not is_side[h]:
                    h = _after(across[h])
            if outline:
                found.append(np.array(outline))
        return found

    def normals(self) -> Floats:
        """Angle-weighted unit normals at the vertices, (V, 3)."""
        faces, x = self.triangulation.faces, self.vertices
        outward = face_normals(faces, x)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        normals = np.zeros_like(x)
        for k in range(3):
            here, to, other = (x[faces[:, (k + j) % 3]] for j in range(3))
            a, b = to - here, other - here
            angles = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
            np.add.at(normals, faces[:, k], angles[:, None] * outward)
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _after(h: int) -> int:
    return h - 2 if h % 3 == 2 else h + 1


def _before(h: int) -> int:
    return h + 2 if h % 3 == 0 else h - 1
