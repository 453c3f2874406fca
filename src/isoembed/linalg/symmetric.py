"""A sparse symmetric matrix, of which the lower triangle is kept: products, and the sizes of the unknowns."""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32
from isoembed.kernel import kernel


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
        return _product(self.indptr, self.indices, self.data, columns).reshape(x.T.shape).T

    def diagonal(self) -> Floats:
        """The diagonal, shape (n,)."""
        return self.data[self.indptr[:-1]]

    def sizes(self) -> Floats:
        """Scale factors s, shape (n,): the largest ``|a_ij| / (s_i s_j)`` of every row is near 1.

        Source: Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices (2001): each
        pass takes the square root of what is off.
        """
        return _sizes(self.indptr, self.indices, self.data)


@kernel
def _product(indptr: Indices32, indices: Indices32, data: Floats, x: Floats) -> Floats:
    y = np.zeros_like(x)
    for c in range(len(x)):
        for column in range(indptr.size - 1):
            own, total = x[c, column], 0.0
            for p in range(indptr[column], indptr[column + 1]):
                row = indices[p]
                total += data[p] * x[c, row]
                if row != column:
                    y[c, row] += data[p] * own
            y[c, column] += total
    return y


@kernel
def _sizes(indptr: Indices32, indices: Indices32, data: Floats) -> Floats:
    n = indptr.size - 1
    s = np.ones(n)
    for _ in range(5):  # 24 decades between neighbors become less than one
        largest = np.zeros(n)
        for column in range(n):
            for p in range(indptr[column], indptr[column + 1]):
                row = indices[p]
                size = abs(data[p]) / s[column] / s[row]
                largest[column] = max(largest[column], size)
                largest[row] = max(largest[row], size)
        for i in range(n):
            if largest[i] > 0:
                s[i] *= np.sqrt(largest[i])
    return s
