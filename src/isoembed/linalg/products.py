"""Products of a sparse matrix with few columns, in compressed rows with indices of 32 bits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32
from isoembed.kernel import kernel


@dataclass(frozen=True, eq=False)
class Rows:
    """A square matrix (n, n) for many products with vectors (n, 3).

    Attributes
    ----------
    indptr, indices : ndarray of int32
    data : ndarray
    """

    indptr: Indices32
    indices: Indices32
    data: Floats

    def __matmul__(self, vectors: Floats) -> Floats:
        """The product with vectors (n, 3)."""
        return _product(self.indptr, self.indices, self.data, vectors)

    def transposed(self, vectors: Floats) -> Floats:
        """The product of the transposed matrix with vectors (n, 3)."""
        return _transposed_product(self.indptr, self.indices, self.data, vectors)


@kernel
def _product(indptr: Indices32, indices: Indices32, data: Floats, vectors: Floats) -> Floats:
    products = np.empty((indptr.size - 1, 3))
    for i in range(indptr.size - 1):
        x = y = z = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            entry, vector = data[p], vectors[indices[p]]
            x += entry * vector[0]
            y += entry * vector[1]
            z += entry * vector[2]
        products[i, 0], products[i, 1], products[i, 2] = x, y, z
    return products


@kernel
def _transposed_product(indptr: Indices32, indices: Indices32, data: Floats, vectors: Floats) -> Floats:
    products = np.zeros((indptr.size - 1, 3))
    for i in range(indptr.size - 1):
        x, y, z = vectors[i]
        for p in range(indptr[i], indptr[i + 1]):
            entry, product = data[p], products[indices[p]]
            product[0] += entry * x
            product[1] += entry * y
            product[2] += entry * z
    return products
