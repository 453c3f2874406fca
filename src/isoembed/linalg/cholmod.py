"""CHOLMOD through scikit-sparse 0.4: supernodal Cholesky or simplicial L D L^T, with symbolic reuse."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from sksparse.cholmod import CholmodNotPositiveDefiniteError, Factor, analyze

from isoembed.arrays import Floats
from isoembed.linalg import backend

# With the padding of supernodes, or the row of each entry.
SUPERNODAL, SIMPLICIAL = backend.BytesPer(9.2, 10, 150), backend.BytesPer(12.0, 10, 150)


class Symbolic(backend.Symbolic):
    """A pattern in elimination order."""

    @property
    def bytes_per(self) -> backend.BytesPer:
        """Memory of the next factors."""
        return SUPERNODAL if self.definite else SIMPLICIAL

    @cached_property
    def _analysis(self) -> Factor:
        # Supernodal is always L L^T, which refuses an indefinite matrix. The simplicial kind is L D L^T.
        mode = "supernodal" if self.definite else "simplicial"
        return analyze(self._matrix(np.ones(self.indices.size)), mode=mode, ordering_method="natural")

    def factor(self, data: Floats) -> Numeric:
        """Factorize the matrix with these entries; raises SingularMatrix."""
        try:
            return Numeric(self._analysis.cholesky(self._matrix(data)))
        except CholmodNotPositiveDefiniteError as error:
            raise self.refusal() from error

    def _matrix(self, data: Floats) -> sp.csc_matrix:
        n = self.indptr.size - 1
        return sp.csc_matrix((data, self.indices, self.indptr), shape=(n, n))


class Numeric:
    """The factors of one matrix."""

    def __init__(self, factor: Factor) -> None:
        self.solve = factor.solve_A
        self._factor = factor

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D."""
        return int((self._factor.D() < 0).sum())
