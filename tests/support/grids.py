"""Matrices with the pattern of a grid."""

import numpy as np
import scipy.sparse as sp

from isoembed.linalg import dissect


def grid(side):
    """A Laplacian, definite, on a square of side * side vertices, and an order that dissects it."""
    line = sp.diags_array(np.ones((2, side)), offsets=(-1, 1), shape=(side, side))
    graph = sp.csc_matrix(sp.kron(line, sp.eye_array(side)) + sp.kron(sp.eye_array(side), line))
    return sp.csc_matrix(5 * sp.eye_array(side**2) - graph), dissect(graph).vertex_order()
