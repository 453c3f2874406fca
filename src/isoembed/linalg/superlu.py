"""SuperLU, which comes with scipy: nothing to install, but every factorization repeats the symbolic part."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from isoembed.linalg.singular import SingularMatrix

TRIANGLE = "both"


class Symbolic:
    """A pattern in elimination order: both triangles, CSC with sorted rows."""

    def __init__(self, indptr: NDArray[np.int32], indices: NDArray[np.int32]) -> None:
        self._indptr, self._indices = indptr, indices

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        n = self._indptr.size - 1
        matrix = sp.csc_matrix((data, self._indices, self._indptr), shape=(n, n))
        try:
            lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SingularMatrix("the matrix is singular: elimination met a zero pivot") from error
        # Down the diagonal this is L D L^T, and the matrix is positive definite if and only if all pivots are
        # positive. A row exchange means that a pivot was zero.
        if (lu.perm_r != lu.perm_c).any() or not (lu.U.diagonal() > 0).all():
            raise SingularMatrix("the matrix is not positive definite")
        return Numeric(lu)


class Numeric:
    """The factors of one matrix."""

    def __init__(self, lu: SuperLU) -> None:
        self._lu = lu

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        return self._lu.solve(b)
