"""SciPy's SuperLU: for matrices that are not symmetric, and for proofs, which bound its rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import scipy.sparse as sp

from isoembed.linalg.singular import SingularMatrix

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU


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
