"""The triangulation of a sphere: faces, edges and who touches whom."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from isoembed.arrays import Indices
from isoembed.kernel import kernel
from isoembed.mesh.checks import checked_tables, index_array
from isoembed.mesh.joining import join


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Triangulation:
    """A triangulated sphere, as the paper's "list of its triangles by vertices".

    Half-edge ``h = 3 f + c`` runs from ``faces[f, c]`` to ``faces[f, (c + 1) % 3]``.

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
    edge_halfedges : ndarray of int64, shape (E, 2)
        The half-edge along the edge (its left face) and the one against it (its right face).

    Raises
    ------
    InvalidMetric
        The faces are not a triangulated sphere; the message names the first offender.

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
    edge_halfedges: Indices

    def __init__(self, faces: ArrayLike) -> None:
        table = index_array(faces, 3, "face", "corners").copy()
        edges, face_edges, edge_halfedges = join(table) or checked_tables(table)
        for name, value in zip(
            ("faces", "edges", "face_edges", "edge_halfedges"),
            (table, edges, face_edges, edge_halfedges),
            strict=True,
        ):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"Triangulation({self.n_vertices} vertices, {self.n_edges} edges, {self.n_faces} faces)"

    @property
    def n_vertices(self) -> int:
        """V, the paper's N_0."""
        return self.n_faces // 2 + 2

    @property
    def n_edges(self) -> int:
        """E = 3 V - 6, the paper's N_1."""
        return len(self.edges)

    @property
    def n_faces(self) -> int:
        """F = 2 V - 4, the paper's N_2."""
        return len(self.faces)

    @cached_property
    def twins(self) -> Indices:
        """(3F,): the half-edge that runs the other way."""
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
        """Index of each edge, (n,), given by its two ends in either order, (n, 2); -1 where it is none."""
        return _find(self.edges, self.n_vertices, pairs)


@kernel
def _find(edges: Indices, n: int, pairs: Indices) -> Indices:
    """The rows of the table of edges that have these ends, or -1."""
    starts = np.zeros(n + 1, dtype=np.int64)  # of the edges by their lower end
    for e in range(len(edges)):
        starts[edges[e, 0] + 1] += 1
    for v in range(n):
        starts[v + 1] += starts[v]
    found = np.full(len(pairs), -1)
    for k in range(len(pairs)):
        low, high = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if low < 0 or high >= n:
            continue
        e, end = starts[low], starts[low + 1]
        while e < end:
            middle = (e + end) // 2
            if edges[middle, 1] < high:
                e = middle + 1
            else:
                end = middle
        if e < starts[low + 1] and edges[e, 1] == high:
            found[k] = e
    return found


Frozen = TypeVar("Frozen", bound=NDArray)


def frozen(array: Frozen) -> Frozen:
    """Make an array read-only, and return it."""
    array.flags.writeable = False
    return array
