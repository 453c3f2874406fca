"""Intrinsic Delaunay triangulation, weighted or not, by edge flips."""

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.delaunay_loops import Weighted, non_delaunay_edges
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip_edges

THINNEST = 1e-15  # height over longest side: thinner triangles are lost in rounding


def make_delaunay(mesh: HalfEdges, weights: Floats, edges: Indices | None = None) -> tuple[int, int]:
    """Flip to the weighted Delaunay triangulation, in place.

    Parameters
    ----------
    mesh : HalfEdges
    weights : ndarray, shape (V,)
        Squared radii, less any constant, so that equal ones make the Delaunay triangulation; in curved space
        the squares of the `chord` of the radii, of which only zeros do.
    edges : ndarray of int, optional
        What `non_delaunay_edges` says, where it is known already.

    Returns
    -------
    int, int
        Flips made, and edges that are not Delaunay but cannot be flipped: a vertex is hidden, and the
        weights have no Delaunay triangulation that uses them all.
    """
    views = mesh.views
    edges = non_delaunay_edges(views, weights) if edges is None else edges
    flips, blocked = flip_edges(edges, Weighted(views, weights))
    # Some that were blocked may have come free by other flips.
    return flips, non_delaunay_edges(views, weights).size if blocked else 0
