"""A proof, in floats, that a sparse symmetric matrix A is positive definite, and by how much.

Elimination down the diagonal without exchanges leaves factors with ``L U = A + dA``. In whatever order it
adds, ``|dA_ij| <= gamma_k (|L| |U|)_ij``, where ``gamma_k = k u / (1 - k u)``, u = 2^-53 and k is the
number of terms of the sum behind the entry (Higham, Accuracy and stability of numerical algorithms, 2002,
lemma 8.4 and theorem 9.3): at most the number of entries in row i of L, and one more as pivots are divided
by through their reciprocals. Let D be the diagonal of U, and ``G = U - D L^T``, which is small because A is
symmetric, and is computed. Then

    A - L D L^T = L G - dA,    |A - L D L^T| <= |L| (gamma |U| + |G|),

entry by entry. The left side is symmetric, so its norm is no larger than the largest row sum on the right.
If D is positive, L D L^T is positive definite, and no eigenvalue of A is less than minus that norm. Applied
to A - s I, this bounds the eigenvalues of A from below. The idea is Rump's (Verification of positive
definiteness, BIT 46, 2006), who takes a bound a priori on the error of Cholesky's method, which would be
some thousand times as large here.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.kernel import kernel
from isoembed.linalg.rounding import GUARD, UNDERFLOW, U, gamma
from isoembed.linalg.superlu import has_row_exchanges, symmetric_lu
from isoembed.linalg.symbolic import SingularMatrix
from isoembed.thresholds import compiled, threshold


@dataclass(frozen=True)
class DefinitenessThresholds:
    """Thresholds of the proof that a matrix is positive definite."""

    spare: int = threshold(6, "roundings", "Of an entry beyond the terms of its sum: in 1 / pivot, D L^T, G.")
    iterations: int = threshold(12, "count", "They exceed the eigenvalue by n^(1/24) or so: 1.6 for 10^5.")
    share: float = threshold(0.5, "relative", "Of the estimated eigenvalue, to be proven.")


DEFINITENESS = DefinitenessThresholds()
_T = compiled(DEFINITENESS)


@dataclass(frozen=True, eq=False)
class PositiveDefinite:
    """A symmetric matrix that was proven positive definite: its eigenvalues are at least `eigenvalue` > 0."""

    eigenvalue: float
    _lu: SuperLU
    _order: Indices

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b, shape (n,), approximately."""
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x


def prove_definite(matrix: sp.csc_array, order: Indices) -> PositiveDefinite:
    """Bound the eigenvalues of a symmetric matrix away from zero.

    Two factorizations: one to estimate the least eigenvalue by inverse iteration, one to prove half of it.

    Parameters
    ----------
    matrix : sparse CSC, (n, n)
        Symmetric, bit by bit; both triangles. What is proven holds for these floats.
    order : ndarray of int, shape (n,)
        Elimination order.

    Raises
    ------
    SingularMatrix
        The matrix is not positive definite, or too little so for rounding to leave a proof.
    """
    permuted = sp.csc_array(matrix[order][:, order])
    lu = symmetric_lu(permuted)
    x = np.random.default_rng(0).normal(size=order.size)
    for _ in range(DEFINITENESS.iterations):
        x = lu.solve(x / np.linalg.norm(x))
    shift = float(DEFINITENESS.share / np.linalg.norm(x))
    shifted = sp.csc_array(permuted - shift * sp.eye_array(order.size, format="csc"))
    lost = _distance_to_definite(symmetric_lu(shifted)) + U * float(np.abs(shifted.diagonal()).max())
    if not lost < shift:
        raise SingularMatrix(
            "the matrix cannot be proven positive definite: its least eigenvalue is about "
            f"{shift / DEFINITENESS.share:.1e}, and rounding takes up to {lost:.1e}"
        )
    return PositiveDefinite((shift - lost) / GUARD, lu, order)


def _distance_to_definite(lu: SuperLU) -> float:
    """Bound the norm of A - L D L^T: so far, if that, are the eigenvalues of A below zero."""
    upper = lu.U
    pivots = upper.diagonal()
    if has_row_exchanges(lu) or not (pivots > 0).all():  # an exchange avoids a pivot of zero
        raise SingularMatrix("the matrix is not positive definite")
    lower = lu.L.tocsr()
    largest = _largest_row_sum(
        lower.indptr, lower.indices, lower.data, upper.indptr, upper.indices, upper.data, pivots
    )
    return float(largest) * GUARD + UNDERFLOW


@kernel
def _largest_row_sum(
    lower_rows: Indices32,
    lower_columns: Indices32,
    lower: Floats,
    upper_columns: Indices32,
    upper_rows: Indices32,
    upper: Floats,
    pivots: Floats,
) -> float:
    """Largest row sum of ``gamma |L| |U| + |L| |G|``; L by rows, U by columns."""
    n = pivots.size
    sizes, asymmetries = np.zeros(n), np.zeros(n)  # row sums of |U| and |G|
    mirrored = np.zeros(n)
    for i in range(n):
        for p in range(lower_rows[i], lower_rows[i + 1]):
            k = lower_columns[p]
            mirrored[k] = pivots[k] * lower[p]
        for p in range(upper_columns[i], upper_columns[i + 1]):
            k = upper_rows[p]
            sizes[k] += abs(upper[p])
            asymmetries[k] += abs(upper[p] - mirrored[k])
            mirrored[k] = 0.0
        for p in range(lower_rows[i], lower_rows[i + 1]):
            k = lower_columns[p]
            asymmetries[k] += abs(mirrored[k])  # no counterpart in U
            mirrored[k] = 0.0
    largest = 0.0
    for i in range(n):
        relative = gamma(lower_rows[i + 1] - lower_rows[i] + _T.spare)
        total = 0.0
        for p in range(lower_rows[i], lower_rows[i + 1]):
            k = lower_columns[p]
            total += abs(lower[p]) * (relative * sizes[k] + asymmetries[k])
        largest = max(largest, total)
    return largest
