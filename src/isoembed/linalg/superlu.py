"""SuperLU, which comes with scipy: nothing to install, but every factorization repeats the symbolic part."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from isoembed.linalg.elimination import Elimination
from isoembed.linalg.singular import SingularMatrix

Pointers = NDArray[np.int32]

# Bytes, measured, for an entry of L and of U; and where scipy copies both, which is how it shows the pivots.
UNSEEN, SEEN = 32, 49


class Symbolic:
    """A pattern in elimination order: the lower triangle, CSC with sorted rows."""

    def __init__(self, indptr: Pointers, indices: Pointers, elimination: Elimination, definite: bool) -> None:
        self._definite, self._count = definite, int(elimination.counts.sum())
        n = indptr.size - 1
        # SuperLU wants both triangles. Numbers from 1 on: scipy drops zeros from sums.
        lower = sp.csc_matrix((np.arange(1, indices.size + 1), indices, indptr), shape=(n, n))
        self._both = (lower + sp.tril(lower, -1).T).tocsc()
        self._both.sort_indices()

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        return (SEEN if self._definite else UNSEEN) * self._count

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        both = self._both
        matrix = sp.csc_matrix((data[both.data - 1], both.indices, both.indptr), shape=both.shape)
        try:
            lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SingularMatrix("the matrix is singular: elimination met a zero pivot") from error
        # Down the diagonal this is L D L^T, and D has as many negative entries as the matrix has negative
        # eigenvalues. A row exchange means that a pivot was zero.
        exchanged = bool((lu.perm_r != lu.perm_c).any())
        if self._definite:
            if exchanged or not (lu.U.diagonal() > 0).all():
                raise SingularMatrix("the matrix is not positive definite")
        elif exchanged:
            raise SingularMatrix("the matrix has no factors L D L^T in this order")
        return Numeric(lu)


class Numeric:
    """The factors of one matrix."""

    def __init__(self, lu: SuperLU) -> None:
        self._lu = lu

    @cached_property
    def negative_pivots(self) -> int:
        """Number of negative entries of D; counted when asked for, because that copies all factors."""
        return int((self._lu.U.diagonal() < 0).sum())

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        return self._lu.solve(b)
