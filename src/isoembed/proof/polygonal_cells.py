"""Faces of a convex polyhedron in a proof: triangles merged across flat edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Indices, Mask
from isoembed.mesh.components import components
from isoembed.mesh.triangulation import Triangulation


@dataclass(frozen=True, eq=False)
class Cells:
    """Connected components of the faces after cutting a sphere along all edges but the flat ones.

    Attributes
    ----------
    labels : ndarray of int, shape (F,)
        Cell of each face, numbered from 0.
    first : ndarray of int, shape (C,)
        First face of each cell.
    sizes : ndarray of int, shape (C,)
        Number of faces of each cell.
    polygonal : ndarray of bool, shape (C,)
        Whether the cell is a disc with as many vertices as sides: a polygon cut along diagonals.
    cell, start, end, far : ndarray of int, shape (H,)
        Half-edges between different cells: their cell, their ends and, if the cell is polygonal, the end of
        the next half-edge of the outline.
    """

    labels: Indices
    first: Indices
    sizes: Indices
    polygonal: Mask
    cell: Indices
    start: Indices
    end: Indices
    far: Indices

    @classmethod
    def across(cls, triangulation: Triangulation, flat: Mask) -> Cells:
        """Merge faces across the flat edges, shape (E,)."""
        t = triangulation
        labels = components(t.edge_faces[flat, 0], t.edge_faces[flat, 1], t.n_faces)
        _, first, sizes = np.unique(labels, return_index=True, return_counts=True)

        outer = np.flatnonzero(~flat[t.face_edges.ravel()])
        cell, start = labels[outer // 3], t.faces.ravel()[outer]
        end = np.roll(t.faces, -1, axis=1).ravel()[outer]
        # n triangles connected by n - 1 edges form a disc with n + 2 sides, unless its corners coincide.
        inner = np.bincount(labels[t.edge_faces[flat, 0]], minlength=len(first))
        corners = np.unique(np.column_stack([cell, start]), axis=0)
        distinct = np.bincount(corners[:, 0], minlength=len(first))
        polygonal = (inner == sizes - 1) & (distinct == sizes + 2)

        key = cell * t.n_vertices + start
        order = np.argsort(key)
        following = np.searchsorted(key[order], cell * t.n_vertices + end)
        far = end[order[np.minimum(following, len(order) - 1)]] if len(order) else end
        return cls(labels, first, sizes, polygonal, cell, start, end, far)
