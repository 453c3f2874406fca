"""SuperLU (of SciPy) as a factorization backend."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from isoembed.arrays import Floats
from isoembed.linalg.symbolic import SingularMatrix, Symbolic

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU

# Bytes for an entry of L, as measured: where the pivots are looked at, scipy copies all of L and of U.
PIVOTS_SEEN, PIVOTS_UNSEEN = 49, 32


def symmetric_lu(matrix: sp.csc_matrix | sp.csc_array) -> SuperLU:
    """Factors L U of a symmetric matrix in its own order, without exchanges but where a pivot is zero."""
    return checked_lu(matrix, "NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def checked_lu(matrix: sp.csc_matrix | sp.csc_array, order: str, **options: object) -> SuperLU:
    """Factors L U in an order of scipy's; raises SingularMatrix where there is no pivot left."""
    from scipy.sparse.linalg import splu  # slow to import, and large matrices do without

    try:
        return splu(matrix, permc_spec=order, **options)
    except RuntimeError as error:
        raise SingularMatrix("the matrix is singular: elimination met a zero pivot") from error


def has_row_exchanges(lu: SuperLU) -> bool:
    """Whether a pivot was zero, so that rows were exchanged."""
    return bool((lu.perm_r != lu.perm_c).any())


@dataclass(eq=False)
class Columns(Symbolic):
    """A pattern in elimination order, and the number of entries of L."""

    count: int

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        return (PIVOTS_SEEN if self.definite else PIVOTS_UNSEEN) * self.count

    @cached_property
    def _both(self) -> sp.csc_matrix:
        """Both triangles, as SuperLU wants them; its data number the entries of the lower one."""
        n, numbers = self.indptr.size - 1, np.arange(1, self.indices.size + 1)
        lower = sp.csc_matrix((numbers, self.indices, self.indptr), shape=(n, n))
        both = (lower + sp.tril(lower, -1).T).tocsc()
        both.sort_indices()
        both.data -= 1  # from 0 on only now: scipy drops zeros from sums
        return both

    def factor(self, data: Floats, *, single: bool = False) -> ColumnFactors:
        """Factorize the matrix with these entries; raises SingularMatrix."""
        both = self._both
        matrix = sp.csc_matrix((data[both.data], both.indices, both.indptr), shape=both.shape)
        lu = symmetric_lu(matrix)
        # This is L D L^T, and D has as many negative entries as the matrix has negative eigenvalues.
        if has_row_exchanges(lu) or (self.definite and not (lu.U.diagonal() > 0).all()):
            raise self.refusal()
        return ColumnFactors(lu)


class ColumnFactors:
    """The factors of one matrix."""

    def __init__(self, lu: SuperLU) -> None:
        self.solve = lu.solve
        self._lu = lu

    @cached_property
    def negative_pivots(self) -> int:
        """Number of negative entries of D; counted when asked for, because that copies all factors."""
        return int((self._lu.U.diagonal() < 0).sum())
