"""Derivatives of geodesic path lengths with respect to the edge lengths crossed.

The triangles along a path, with the path itself as one more bar, form a bar framework in the plane with a
single self-stress: w_e on the edges and -1 on the path, in equilibrium at every corner.  For changes that
keep the triangles in one plane, ``d path = sum of w_e dl_e``.  The corners are balanced successively, from
the end of the path back to its start; each then has two remaining edges.
"""

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Indices
from isoembed.errors import InvalidParameter
from isoembed.intrinsic.edge_paths import EdgePaths
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.path_loops import balance


def path_derivatives(paths: EdgePaths) -> csr_array:
    """Derivatives of path lengths with respect to half-edge lengths, sparse of shape (n, 3F).

    The derivative of an edge is stored at one of its two half-edges.

    Parameters
    ----------
    paths : EdgePaths
        Paths on flat triangles that form a simplicial complex.

    Raises
    ------
    InvalidParameter
        The triangles are not flat, or a path was not found.
    """
    tables = paths.tables
    if tables.curvature != 0:
        raise InvalidParameter(f"the triangles have the curvature {tables.curvature:g}, not 0")
    if paths.unresolved.size:
        edge = int(paths.unresolved[0])
        raise InvalidParameter(f"the path of edge {edge} {paths.ends[edge].tolist()} has not been found")
    counts = np.diff(paths.offsets)
    pointers = np.concatenate([[0], np.cumsum(np.where(counts == 0, 1, 2 * counts + 3))])
    columns, values = np.zeros(pointers[-1], dtype=np.int64), np.ones(pointers[-1])
    columns[pointers[:-1][counts == 0]] = _sides(tables, paths.ends[counts == 0])
    views = tables.views
    for e in np.flatnonzero(counts).tolist():
        crossed, entries = slice(*paths.offsets[e : e + 2]), slice(*pointers[e : e + 2])
        balance(paths.halfedges[crossed], views, columns[entries], values[entries])
    return csr_array((values, columns, pointers), shape=(len(counts), tables.corners.size))


def _sides(tables: HalfEdges, ends: Indices) -> Indices:
    """Half-edges between pairs of vertices (n, 2)."""
    n = int(tables.corners.max()) + 1
    keys = [np.min(pair, axis=0) * n + np.max(pair, axis=0) for pair in (tables.ends, ends.T)]
    order = np.argsort(keys[0], kind="stable")
    return np.asarray(order[np.searchsorted(keys[0][order], keys[1])])
