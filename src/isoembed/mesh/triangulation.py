"""Triangulations of surfaces: faces, edges, boundary, adjacency; checks that they are closed, or spheres."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from isoembed.arrays import Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.mesh.checks import check_euler, checked_tables, index_array
from isoembed.mesh.edge_tables import edge_tables
from isoembed.mesh.loops import find

LONGEST_HOLE = 6  # sides of a hole that may be an accident


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Triangulation:
    """A triangulated surface, as the paper's "list of its triangles by vertices".

    The surface is connected and oriented: a sphere, as in the paper and unless stated otherwise, or a surface
    with boundary or of higher genus.  Half-edge ``h = 3 f + c`` runs from ``faces[f, c]`` to
    ``faces[f, (c + 1) % 3]``.

    Parameters
    ----------
    faces : array_like of int, shape (F, 3)
        Triangles, vertices numbered from 0 without gaps.

    Attributes
    ----------
    faces : ndarray of int64, shape (F, 3)
        Triangles oriented consistently with face 0; others are reversed.
    edges : ndarray of int64, shape (E, 2)
        Edges, smaller index first, in lexicographic order.
    face_edges : ndarray of int64, shape (F, 3)
        Edge of each half-edge.
    edge_sides : ndarray of int64, shape (E, 2)
        Half-edges along the edge (in its left face) and against it (in its right face); -1 where a boundary
        edge has no face.
    n_vertices : int
        Number of vertices V, the paper's N_0.

    Raises
    ------
    InvalidMetric
        The faces are not a connected oriented surface; the message names the first offender.

    Warns
    -----
    MeshNote
        Faces are reversed.

    Examples
    --------
    >>> t = Triangulation([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    >>> t.n_vertices, t.n_edges, t.n_faces
    (4, 6, 4)
    """

    faces: Indices
    edges: Indices
    face_edges: Indices
    edge_sides: Indices
    n_vertices: int

    def __init__(self, faces: ArrayLike) -> None:
        table = index_array(faces, 3, "face", "corners").copy()
        edges, face_edges, edge_sides = edge_tables(table) or checked_tables(table)
        for name, value in zip(
            ("faces", "edges", "face_edges", "edge_sides"),
            (table, edges, face_edges, edge_sides),
            strict=True,
        ):
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "n_vertices", int(table.max()) + 1)

    def __repr__(self) -> str:
        return f"Triangulation({self.n_vertices} vertices, {self.n_edges} edges, {self.n_faces} faces)"

    @property
    def n_edges(self) -> int:
        """Number of edges E, the paper's N_1: 3 V - 6 on a sphere."""
        return len(self.edges)

    @property
    def n_faces(self) -> int:
        """Number of faces F, the paper's N_2: 2 V - 4 on a sphere."""
        return len(self.faces)

    @property
    def euler_characteristic(self) -> int:
        """V - E + F = 2 - 2 g - b for genus g and b boundary components."""
        return self.n_vertices - self.n_edges + self.n_faces

    @property
    def genus(self) -> int:
        """Number of handles: 0 for a sphere and a disk."""
        return (2 - len(self.boundaries) - self.euler_characteristic) // 2

    @cached_property
    def boundary_edges(self) -> Mask:
        """Mask of boundary edges, shape (E,)."""
        left, right = self.edge_sides.T
        return frozen((left < 0) | (right < 0))

    @cached_property
    def boundaries(self) -> tuple[Indices, ...]:
        """Vertices along each boundary component, in the direction of its half-edges."""
        h = self.edge_sides[self.boundary_edges].max(axis=1)
        corners = self.faces.ravel()
        follows = dict(zip(corners[h].tolist(), corners[h - h % 3 + (h + 1) % 3].tolist(), strict=True))
        loops = []
        while follows:
            v = min(follows)
            loop = []
            while v in follows:
                loop.append(v)
                v = follows.pop(v)
            loops.append(frozen(np.array(loop)))
        return tuple(loops)

    @cached_property
    def is_closed(self) -> bool:
        """Whether the surface has no boundary."""
        return bool((self.edge_sides >= 0).all())

    @cached_property
    def boundary_vertices(self) -> Mask:
        """Mask of boundary vertices, shape (V,)."""
        there = np.zeros(self.n_vertices, dtype=np.bool_)
        there[self.edges[self.boundary_edges].ravel()] = True
        return frozen(there)

    @property
    def is_sphere(self) -> bool:
        """Whether the surface is closed and of genus 0."""
        return self.is_closed and self.euler_characteristic == 2

    @cached_property
    def _small_hole(self) -> Indices:
        """Vertices along a boundary so short that faces may be missing inside; empty if there is none."""
        longest = min(LONGEST_HOLE, (self.n_vertices - 1) // 2)
        none = np.empty(0, dtype=np.int64)
        return next((loop for loop in self.boundaries if len(loop) <= longest), none)

    def check_sphere(self, what: str = "", instead: str = "") -> None:
        """Raise `InvalidMetric` if the surface is not a sphere; `what` names the purpose in the message."""
        if what and not self.is_sphere:
            kind = f"genus {self.genus}" if self.is_closed else "a boundary"
            after = f": {instead}" if instead else ""
            raise InvalidMetric(f"{what} closed surfaces of genus 0, and this one has {kind}{after}")
        self.check_closed()
        check_euler(self.n_vertices, self.n_faces)

    def check_closed(self) -> None:
        """Raise `InvalidMetric` if the surface has a boundary."""
        if not self.is_closed:
            raise InvalidMetric(f"{self._open_edge}{self._missing_faces()}")

    @property
    def _open_edge(self) -> str:
        """Clause on the first boundary edge."""
        e = int(np.argmax(self.boundary_edges))
        f = int(self.edge_sides[e].max()) // 3
        return (
            f"edge {self.edges[e].tolist()} is in face {f} only ({self.boundary_edges.sum()} such "
            "boundary edges): the surface is not closed"
        )

    def _missing_faces(self) -> str:
        """Clause on faces that may be missing."""
        hole = np.roll(self._small_hole[::-1], 1).tolist()  # as a face inside would run
        if len(hole) <= 3:
            return f"; the face {hole} may be missing" if hole else ""
        edge = f", with the edge {hole[::2]} or {hole[1::2]}" if len(hole) == 4 else ""
        return f"; {len(hole) - 2} faces may be missing between the vertices {hole}{edge}"

    @property
    def edge_halfedges(self) -> Indices:
        """`edge_sides` of a closed surface, shape (E, 2); raises `InvalidMetric` for others."""
        self.check_closed()
        return self.edge_sides

    @cached_property
    def edge_flanks(self) -> Indices:
        """`edge_sides` with the half-edge of a boundary edge repeated, as if flat there, shape (E, 2)."""
        return (
            self.edge_sides
            if self.is_closed
            else frozen(np.where(self.edge_sides < 0, self.edge_sides[:, ::-1], self.edge_sides))
        )

    @cached_property
    def sides_across(self) -> Indices:
        """Opposite half-edge of each half-edge, -1 on the boundary, shape (3F,)."""
        across = np.full(self.faces.size, -1)
        along, against = self.edge_sides[~self.boundary_edges].T
        across[along], across[against] = against, along
        return frozen(across)

    @cached_property
    def twins(self) -> Indices:
        """Opposite half-edge of each half-edge of a closed surface, shape (3F,)."""
        along, against = self.edge_halfedges.T
        twins = np.empty(self.faces.size, dtype=np.int64)
        twins[along], twins[against] = against, along
        return frozen(twins)

    @cached_property
    def edge_faces(self) -> Indices:
        """Left and right face of each edge, shape (E, 2)."""
        return frozen(self.edge_halfedges // 3)

    @cached_property
    def degrees(self) -> Indices:
        """Number of edges at each vertex, shape (V,)."""
        return frozen(np.bincount(self.edges.ravel(), minlength=self.n_vertices))

    @cached_property
    def adjacency(self) -> csr_array:
        """Vertex adjacency matrix, shape (V, V)."""
        a, b = self.edges.T
        ones = np.ones(2 * self.n_edges)
        ends = (np.concatenate([a, b]), np.concatenate([b, a]))
        adjacency = csr_array((ones, ends), shape=(self.n_vertices, self.n_vertices))
        frozen(adjacency.data)
        return adjacency

    @cached_property
    def incidence(self) -> csr_array:
        """Incidence matrix, shape (V, E): 1 at the lower endpoint of an edge, -1 at the higher."""
        signs = np.repeat([1.0, -1.0], self.n_edges)
        ends = (self.edges.T.ravel(), np.tile(np.arange(self.n_edges), 2))
        incidence = csr_array((signs, ends), shape=(self.n_vertices, self.n_edges))
        frozen(incidence.data)
        return incidence

    def edge_indices(self, pairs: Indices) -> Indices:
        """Indices (n,) of the edges with given endpoints (n, 2), in either order; -1 for other pairs."""
        pairs = np.ascontiguousarray(pairs, dtype=np.int64).reshape(-1, 2)
        return find(self.edges, self.n_vertices, pairs)


Frozen = TypeVar("Frozen", bound=NDArray)


def frozen(array: Frozen) -> Frozen:
    """Make an array read-only and return it."""
    array.flags.writeable = False
    return array
