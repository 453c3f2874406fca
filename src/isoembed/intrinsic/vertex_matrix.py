"""Sparse symmetric matrices over the vertices with an entry for every edge, such as the Laplacian."""

from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.vertex_matrix_loops import assembled


def vertex_matrix(corners: Indices, twins: Indices, values: Floats, diagonal: Floats) -> csc_array:
    """Assemble a matrix from values on half-edges and vertices, keeping zeros in its pattern.

    Parameters
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As in `isoembed.intrinsic.halfedges.HalfEdges`.
    values : ndarray, shape (3F,)
        Entries for the two ends of each half-edge; equal on twins.
    diagonal : ndarray, shape (V,)

    Returns
    -------
    csc_array, shape (V, V)
        Symmetric matrix with sorted row indices.  Multiple edges are summed, loops added to the diagonal.
    """
    n = diagonal.size
    indptr, indices, data = assembled(corners, twins, values, diagonal)
    return csc_array((data, indices, indptr), shape=(n, n))
