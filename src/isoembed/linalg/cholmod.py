"""CHOLMOD through scikit-sparse 0.4: supernodal Cholesky with symbolic reuse."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from sksparse.cholmod import CholmodNotPositiveDefiniteError, analyze
from sksparse.cholmod import Factor as CholmodFactor

from isoembed.linalg.singular import SingularMatrix

TRIANGLE = "lower"


class Symbolic:
    """A pattern in elimination order: the lower triangle, CSC with sorted rows."""

    def __init__(self, indptr: NDArray[np.int32], indices: NDArray[np.int32]) -> None:
        self._indptr, self._indices = indptr, indices
        # Supernodal is always L L^T. The simplicial kind is L D L^T, which would accept an indefinite matrix.
        pattern = self._matrix(np.ones(indices.size))
        self._symbolic = analyze(pattern, mode="supernodal", ordering_method="natural")

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        try:
            return Numeric(self._symbolic.cholesky(self._matrix(data)))
        except CholmodNotPositiveDefiniteError as error:
            raise SingularMatrix("the matrix is not positive definite") from error

    def _matrix(self, data: NDArray[np.float64]) -> sp.csc_matrix:
        n = self._indptr.size - 1
        return sp.csc_matrix((data, self._indices, self._indptr), shape=(n, n))


class Numeric:
    """The factors of one matrix."""

    def __init__(self, factor: CholmodFactor) -> None:
        self._factor = factor

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        return self._factor.solve_A(b)
