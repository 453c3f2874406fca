"""Sparse symmetric matrices stored by their lower triangle: products and scaling."""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32
from isoembed.linalg.symmetric_loops import product, sizes


@dataclass(frozen=True, eq=False)
class SymmetricMatrix:
    """The lower triangle in compressed columns, rows sorted, the whole diagonal among them.

    Attributes
    ----------
    indptr, indices : ndarray of int32, shapes (n + 1,) and (nnz,)
    data : ndarray, shape (nnz,)
    """

    indptr: Indices32
    indices: Indices32
    data: Floats

    def __matmul__(self, x: Floats) -> Floats:
        """The product with x, shape (n,) or (n, k)."""
        columns = np.ascontiguousarray(x.T).reshape(-1, len(x))
        return product(self.indptr, self.indices, self.data, columns).reshape(x.T.shape).T

    def diagonal(self) -> Floats:
        """The diagonal, shape (n,)."""
        return self.data[self.indptr[:-1]]

    def sizes(self) -> Floats:
        """Scale factors s, shape (n,): the largest ``|a_ij| / (s_i s_j)`` of every row is near 1.

        Source: Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices (2001): each
        pass takes the square root of what is off.
        """
        return sizes(self.indptr, self.indices, self.data)
