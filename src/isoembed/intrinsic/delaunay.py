"""Intrinsic Delaunay triangulation, weighted or not, by edge flips."""

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.delaunay_loops import Weighted, non_delaunay_edges
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip_edges

THINNEST = 1e-15  # height over longest side: below, triangles degenerate by rounding


def make_delaunay(mesh: HalfEdges, weights: Floats, edges: Indices | None = None) -> tuple[int, int]:
    """Flip to the weighted Delaunay triangulation, in place.

    Parameters
    ----------
    mesh : HalfEdges
    weights : ndarray, shape (V,)
        Squared radii, up to a constant; equal weights give the Delaunay triangulation.  In curved space, the
        squared `chord` of the radii; only zeros give the Delaunay triangulation.
    edges : ndarray of int, optional
        Result of `non_delaunay_edges`, if known.

    Returns
    -------
    int, int
        Number of flips, and number of edges that are not Delaunay but cannot be flipped: in this case a
        vertex is hidden, and the weighted Delaunay triangulation does not use all vertices.
    """
    views = mesh.views
    edges = non_delaunay_edges(views, weights) if edges is None else edges
    flips, blocked = flip_edges(edges, Weighted(views, weights))
    # Other flips may have unblocked edges.
    return flips, non_delaunay_edges(views, weights).size if blocked else 0
