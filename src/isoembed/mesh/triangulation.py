"""Triangulations of surfaces: faces, edges, boundary and adjacency."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from isoembed.arrays import Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.mesh.checks import check_euler, checked_tables, index_array
from isoembed.mesh.joining import join
from isoembed.mesh.loops import find


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Triangulation:
    """A triangulated surface, as the paper's "list of its triangles by vertices".

    It is connected and oriented: a sphere, in the paper and in all that does not say otherwise, or a surface
    with boundary or of higher genus.  Half-edge ``h = 3 f + c`` runs from ``faces[f, c]`` to
    ``faces[f, (c + 1) % 3]``.

    Parameters
    ----------
    faces : array_like of int, shape (F, 3)
        Triangles, vertices numbered from 0 without gaps.

    Attributes
    ----------
    faces : ndarray of int64, shape (F, 3)
        Oriented as face 0 is; faces that were not are turned over.
    edges : ndarray of int64, shape (E, 2)
        Smaller index first, in lexicographic order.
    face_edges : ndarray of int64, shape (F, 3)
        The edge of each half-edge.
    edge_sides : ndarray of int64, shape (E, 2)
        The half-edge along the edge (its left face) and the one against it (its right face); -1 on the side
        of a boundary edge that has no face.
    n_vertices : int
        V, the paper's N_0.

    Raises
    ------
    InvalidMetric
        The faces are not a connected oriented surface; the message names the first offender.

    Warns
    -----
    MeshNote
        Faces are turned over.

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
        edges, face_edges, edge_sides = join(table) or checked_tables(table)
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
        """E, the paper's N_1: 3 V - 6 on a sphere."""
        return len(self.edges)

    @property
    def n_faces(self) -> int:
        """F, the paper's N_2: 2 V - 4 on a sphere."""
        return len(self.faces)

    @property
    def euler_characteristic(self) -> int:
        """V - E + F: 2 - 2 g - b, g the genus and b the number of boundaries."""
        return self.n_vertices - self.n_edges + self.n_faces

    @property
    def genus(self) -> int:
        """The number of handles: 0 of a sphere and of a disc."""
        return (2 - len(self.boundaries) - self.euler_characteristic) // 2

    @cached_property
    def boundary_edges(self) -> Mask:
        """(E,): whether an edge is on the boundary."""
        left, right = self.edge_sides.T
        return frozen((left < 0) | (right < 0))

    @cached_property
    def boundaries(self) -> tuple[Indices, ...]:
        """The vertices along each boundary, in the direction of the half-edges there."""
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
        """Whether there is no boundary."""
        return bool((self.edge_sides >= 0).all())

    @cached_property
    def boundary_vertices(self) -> Mask:
        """(V,): whether a vertex is on the boundary."""
        there = np.zeros(self.n_vertices, dtype=np.bool_)
        there[self.edges[self.boundary_edges].ravel()] = True
        return frozen(there)

    @property
    def is_sphere(self) -> bool:
        """Whether the surface is closed and of genus 0."""
        return self.is_closed and self.euler_characteristic == 2

    def check_sphere(self, what: str = "", instead: str = "") -> None:
        """Refuse surfaces with boundary and of higher genus, for what is asked; raises InvalidMetric."""
        if what and not self.is_sphere:
            kind = f"genus {self.genus}" if self.is_closed else "a boundary"
            after = f": {instead}" if instead else ""
            raise InvalidMetric(f"{what} closed surfaces of genus 0, and this one has {kind}{after}")
        self.check_closed()
        check_euler(self.n_vertices, self.n_faces)

    def check_closed(self) -> None:
        """Refuse surfaces with boundary; raises InvalidMetric."""
        if not self.is_closed:
            e = int(np.argmax(self.boundary_edges))
            f = int(self.edge_sides[e].max()) // 3
            raise InvalidMetric(
                f"edge {self.edges[e].tolist()} is in face {f} only ({self.boundary_edges.sum()} such "
                "boundary edges): the surface is not closed"
            )

    @property
    def edge_halfedges(self) -> Indices:
        """(E, 2): `edge_sides` of a closed surface; raises InvalidMetric for others."""
        self.check_closed()
        return self.edge_sides

    @cached_property
    def edge_flanks(self) -> Indices:
        """(E, 2): `edge_sides`, with the only half-edge of a boundary edge twice, as if flat there."""
        return (
            self.edge_sides
            if self.is_closed
            else frozen(np.where(self.edge_sides < 0, self.edge_sides[:, ::-1], self.edge_sides))
        )

    @cached_property
    def sides_across(self) -> Indices:
        """(3F,): the half-edge that runs the other way, -1 on the boundary."""
        across = np.full(self.faces.size, -1)
        along, against = self.edge_sides[~self.boundary_edges].T
        across[along], across[against] = against, along
        return frozen(across)

    @cached_property
    def twins(self) -> Indices:
        """(3F,): the half-edge that runs the other way, on a closed surface."""
        along, against = self.edge_halfedges.T
        twins = np.empty(self.faces.size, dtype=np.int64)
        twins[along], twins[against] = against, along
        return frozen(twins)

    @cached_property
    def edge_faces(self) -> Indices:
        """(E, 2): the left and the right face of each edge."""
        return frozen(self.edge_halfedges // 3)

    @cached_property
    def degrees(self) -> Indices:
        """(V,): edges at each vertex."""
        return frozen(np.bincount(self.edges.ravel(), minlength=self.n_vertices))

    @cached_property
    def adjacency(self) -> csr_array:
        """(V, V): ones where two vertices share an edge."""
        a, b = self.edges.T
        ones = np.ones(2 * self.n_edges)
        ends = (np.concatenate([a, b]), np.concatenate([b, a]))
        adjacency = csr_array((ones, ends), shape=(self.n_vertices, self.n_vertices))
        frozen(adjacency.data)
        return adjacency

    @cached_property
    def incidence(self) -> csr_array:
        """(V, E): 1 where an edge begins, at its lower end, and -1 where it ends."""
        signs = np.repeat([1.0, -1.0], self.n_edges)
        ends = (self.edges.T.ravel(), np.tile(np.arange(self.n_edges), 2))
        incidence = csr_array((signs, ends), shape=(self.n_vertices, self.n_edges))
        frozen(incidence.data)
        return incidence

    def edge_indices(self, pairs: Indices) -> Indices:
        """Index of each edge, (n,), given by its two ends in either order, (n, 2); -1 for other pairs."""
        pairs = np.ascontiguousarray(pairs, dtype=np.int64).reshape(-1, 2)
        return find(self.edges, self.n_vertices, pairs)


Frozen = TypeVar("Frozen", bound=NDArray)


def frozen(array: Frozen) -> Frozen:
    """Make an array read-only, and return it."""
    array.flags.writeable = False
    return array
