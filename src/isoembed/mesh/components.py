"""Connected components of graphs."""

import numpy as np
from scipy.sparse import coo_array, csr_array

from isoembed.arrays import Indices, Mask


def components(u: Indices, v: Indices, n: int) -> Indices:
    """Component of each of n nodes of a graph, numbered from 0 in the order of their first nodes.

    Parameters
    ----------
    u, v : ndarray of int, shape (m,)
        Endpoints of the edges.
    n : int

    Returns
    -------
    ndarray of int64, shape (n,)
    """
    return _labels(coo_array((np.ones(len(u)), (u, v)), shape=(n, n)))


def connected_parts(adjacency: csr_array, mask: Mask) -> list[Indices]:
    """Nodes of each connected component of the subgraph induced by a mask, given the adjacency matrix."""
    nodes = np.flatnonzero(mask)
    labels = _labels(adjacency[nodes][:, nodes])
    return [nodes[labels == label] for label in range(labels.max(initial=-1) + 1)]


def _labels(graph: coo_array | csr_array) -> Indices:
    from scipy.sparse.csgraph import connected_components  # slow to import, and convex surfaces do without

    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
