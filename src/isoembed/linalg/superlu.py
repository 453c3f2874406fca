"""SuperLU, which comes with scipy: nothing to install, but every factorization repeats the symbolic part."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from isoembed.linalg.singular import SingularMatrix

TRIANGLE = "both"


class Symbolic:
    """A pattern in elimination order: both triangles, CSC with sorted rows."""

    def __init__(self, indptr: NDArray[np.int32], indices: NDArray[np.int32], definite: bool) -> None:
        self._indptr, self._indices, self._definite = indptr, indices, definite

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        n = self._indptr.size - 1
        matrix = sp.csc_matrix((data, self._indices, self._indptr), shape=(n, n))
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
