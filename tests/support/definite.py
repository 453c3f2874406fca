"""Proof that a matrix is definite, from the two steps with which `isoembed.proof.row_rank` begins."""

import scipy.sparse as sp

from isoembed.proof.definite import (
    PROVEN_SHARE,
    PositiveDefinite,
    hidden,
    lost_to_rounding,
    smallest_eigenvalue,
)
from isoembed.proof.rounding import GUARD


def prove_definite(matrix, order):
    """The matrix with a lower bound on its eigenvalues, about half of the least one."""
    permuted = sp.csc_array(matrix[order][:, order])
    lu, estimate = smallest_eigenvalue(permuted)
    shift = PROVEN_SHARE * estimate
    lost = lost_to_rounding(permuted, shift)
    if not lost < shift:
        raise hidden(estimate, lost)
    return PositiveDefinite((shift - lost) / GUARD, lu, order)
