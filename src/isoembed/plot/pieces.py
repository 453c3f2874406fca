"""Subdivision of triangles in hyperbolic and spherical space for drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.space import Space


@dataclass(frozen=True, eq=False)
class Pieces:
    """Triangles repeatedly divided in four by the midpoints of their edges.

    Attributes
    ----------
    faces : ndarray of int, shape (4^n F, 3)
        Pieces of the triangles, consecutive for each.  The first vertices are those of the triangles.
    edges : ndarray of int, shape (2^n E, 2)
        Pieces of the edges.
    owners : ndarray of int, shape (2^n E,)
        Original edge of each piece.
    parents : sequence of n ndarrays of int, shape (m, 2)
        Endpoints of the edges whose midpoints are the vertices added by each subdivision.
    """

    faces: Indices
    edges: Indices
    owners: Indices
    parents: Sequence[Indices] = ()

    @classmethod
    def whole(cls, faces: Indices, edges: Indices) -> Pieces:
        """Triangles (F, 3) and edges (E, 2) without subdivision."""
        return cls(faces, edges, np.arange(len(edges)))

    @property
    def cuts(self) -> int:
        """Number of subdivisions n."""
        return len(self.parents)

    @property
    def per_face(self) -> int:
        """Number of pieces of a triangle."""
        return int(4**self.cuts)

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return int(self.faces.max()) + 1

    def cut(self) -> Pieces:
        """Pieces after one more subdivision."""
        n, (a, b, c) = self.n_vertices, self.faces.T
        sides = np.concatenate([np.column_stack(pair) for pair in ((a, b), (b, c), (c, a))])
        ends = np.sort(np.concatenate([sides, self.edges]), axis=1)
        parents, index = np.unique(ends, axis=0, return_inverse=True)
        p, q, r, on_edges = np.split(n + index.ravel(), np.cumsum([len(a)] * 3))
        pieces = [np.column_stack(corners) for corners in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
        halves = [np.column_stack([end, on_edges]) for end in self.edges.T]
        return Pieces(
            np.stack(pieces, axis=1).reshape(-1, 3),
            np.concatenate(halves),
            np.tile(self.owners, 2),
            (*self.parents, parents),
        )

    def values(self, values: Floats) -> Floats:
        """Values at all vertices, averaged at midpoints, from those at the vertices of the triangles."""
        for ends in self.parents:
            values = np.concatenate([values, values[ends].mean(axis=1)])
        return values

    def points(self, space: Space, points: Floats) -> Floats:
        """Points of space at all vertices, (n, 3), on geodesic edges and in planar triangles."""
        for ends in self.parents:
            points = np.concatenate([points, middles(space, points[ends])])
        return points

    def beside(self) -> Indices:
        """Pieces of triangles on both sides of the edge pieces, shape (2^n E, 2)."""
        n, keys = self.n_vertices, self._keys()
        order = np.argsort(keys)
        a, b = self.edges.T
        halves = [order[np.searchsorted(keys, key, sorter=order)] for key in (a * n + b, b * n + a)]
        return np.column_stack(halves) // 3

    def edges_of_faces(self) -> Indices:
        """Original edges of the sides of `faces` that ascend to a larger vertex; -1 inside a triangle."""
        n, keys = self.n_vertices, self._keys()
        low, high = np.sort(self.edges, axis=1).T
        own = low * n + high
        order = np.argsort(own)
        rising = keys[keys // n < keys % n]
        place = order[np.minimum(np.searchsorted(own, rising, sorter=order), len(own) - 1)]
        return np.where(own[place] == rising, self.owners[place], -1)

    def nearest(self) -> Indices:
        """Index of an original vertex near each vertex of the pieces."""
        own = np.arange(self.n_vertices - sum(map(len, self.parents)))
        for ends in self.parents:
            own = np.append(own, own[ends[:, 0]])
        return own

    def _keys(self) -> Indices:
        """Integer key of the endpoints of each side of `faces`."""
        return (self.faces * self.n_vertices + np.roll(self.faces, -1, axis=1)).ravel()


def middles(space: Space, ends: Floats) -> Floats:
    """Midpoints, (n, 3), of the geodesics between pairs of points (n, 2, 3)."""
    sums, heights = ends.sum(axis=1), space.heights(ends).sum(axis=1)
    squares = heights * heights + space.curvature * np.einsum("ij,ij->i", sums, sums)
    return sums / np.sqrt(squares)[:, None]
