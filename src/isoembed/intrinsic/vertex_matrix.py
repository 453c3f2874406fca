"""Sparse symmetric matrices over the vertices with an entry for every edge (as the Laplacian)."""

from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.vertex_matrix_loops import assembled


def vertex_matrix(corners: Indices, twins: Indices, values: Floats, diagonal: Floats) -> csc_array:
    """Sum values by half-edge and by vertex into a matrix; what vanishes is kept in its pattern.

    Parameters
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As of `isoembed.intrinsic.halfedges.HalfEdges`.
    values : ndarray, shape (3F,)
        The entry at the two ends of each half-edge; equal on twins.
    diagonal : ndarray, shape (V,)

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric, its rows sorted within columns.  Repeated edges are summed, and loops into the diagonal.
    """
    n = diagonal.size
    indptr, indices, data = assembled(corners, twins, values, diagonal)
    return csc_array((data, indices, indptr), shape=(n, n))
