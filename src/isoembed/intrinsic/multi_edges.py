"""Flips that remove multiple edges, toward a simplicial complex."""

import numpy as np

from isoembed.arrays import Indices, Mask
from isoembed.intrinsic.delaunay_loops import separate_edges
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.polygons import Polygons, lay_out


def repeated(mesh: HalfEdges) -> Indices:
    """Lower half-edges of loops and multiple edges."""
    h = mesh.edges
    a, b = (end[h] for end in mesh.ends)
    n = int(mesh.corners.max()) + 1
    _, pair, count = np.unique(
        np.minimum(a, b) * n + np.maximum(a, b), return_inverse=True, return_counts=True
    )
    return h[(a == b) | (count[pair] > 1)]


def remove_multi_edges(mesh: HalfEdges, kept: Mask) -> None:
    """Flip edges in place to remove loops and multiple edges, as far as possible.

    Parameters
    ----------
    mesh : HalfEdges
    kept : ndarray of bool, shape (3F,)
        Half-edges of edges that must not be flipped; updated by the flips.
    """
    edges = repeated(mesh)
    if edges.size == 0:
        return
    n = int(mesh.corners.max()) + 1
    flips = 1
    while edges.size and flips:
        flips = separate_edges(edges, mesh.views, kept, n)
        edges = repeated(mesh)


def separated(mesh: HalfEdges, kept: Mask, polygons: Polygons) -> Polygons:
    """Apply `remove_multi_edges`, and lay out each changed triangle separately."""
    before = mesh.corners.copy()
    remove_multi_edges(mesh, kept)
    changed = np.repeat((mesh.corners != before).reshape(-1, 3).any(axis=1), 3)
    if not changed.any():
        return polygons
    single = lay_out(mesh, np.ones_like(kept))
    return Polygons(
        mesh.corners,
        mesh.twins,
        np.where(changed, single.z, polygons.z),
        polygons.fixed | changed | changed[mesh.twins],
        np.where(changed[::3], polygons.cells.max() + 1 + single.cells, polygons.cells),
        polygons.curvature,
    )
