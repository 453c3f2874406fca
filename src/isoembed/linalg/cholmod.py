"""CHOLMOD through scikit-sparse 0.4: supernodal Cholesky or simplicial L D L^T, with symbolic reuse."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from sksparse.cholmod import CholmodNotPositiveDefiniteError, analyze
from sksparse.cholmod import Factor as CholmodFactor

from isoembed.linalg.elimination import Elimination
from isoembed.linalg.singular import SingularMatrix

Pointers = NDArray[np.int32]

# Bytes, measured: for an entry of L, with its padding or its row; for an entry of the matrix, and for a row.
SUPERNODAL, SIMPLICIAL, ENTRY, ROW = 9.2, 12.0, 10, 150


class Symbolic:
    """A pattern in elimination order: the lower triangle, CSC with sorted rows."""

    def __init__(self, indptr: Pointers, indices: Pointers, elimination: Elimination, definite: bool) -> None:
        self._indptr, self._indices, self._definite = indptr, indices, definite
        self._count = int(elimination.counts.sum())
        # Supernodal is always L L^T, which refuses an indefinite matrix. The simplicial kind is L D L^T.
        pattern = self._matrix(np.ones(indices.size))
        mode = "supernodal" if definite else "simplicial"
        self._symbolic = analyze(pattern, mode=mode, ordering_method="natural")

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        factor = SUPERNODAL if self._definite else SIMPLICIAL
        return int(factor * self._count) + ENTRY * self._indices.size + ROW * self._indptr.size

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        try:
            return Numeric(self._symbolic.cholesky(self._matrix(data)))
        except CholmodNotPositiveDefiniteError as error:
            if self._definite:
                raise SingularMatrix("the matrix is not positive definite") from error
            raise SingularMatrix("the matrix has no factors L D L^T in this order") from error

    def _matrix(self, data: NDArray[np.float64]) -> sp.csc_matrix:
        n = self._indptr.size - 1
        return sp.csc_matrix((data, self._indices, self._indptr), shape=(n, n))


class Numeric:
    """The factors of one matrix."""

    def __init__(self, factor: CholmodFactor) -> None:
        self._factor = factor

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D."""
        return int((self._factor.D() < 0).sum())

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        return self._factor.solve_A(b)
