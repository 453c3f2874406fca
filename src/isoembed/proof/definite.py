"""Proof of positive definiteness of a sparse symmetric matrix in floating point.

Elimination without pivoting gives factors with ``L U = A + dA``. In any order of summation,
``|dA_ij| <= gamma_k (|L| |U|)_ij``, where ``gamma_k = k u / (1 - k u)``, u = 2^-53 and k is the
number of terms in the sum for the entry (Higham, Accuracy and stability of numerical algorithms, 2002,
lemma 8.4 and theorem 9.3): at most the number of entries in row i of L, plus one because divisions by pivots
use their reciprocals. Let D be the diagonal of U, and ``G = U - D L^T``, which is small because A is
symmetric, and is computed.  With ``H = G^T D^-1 / 2``, the symmetric part of L U is

    (L U + U^T L^T) / 2 = (L + H) D (L + H)^T - G^T D^-1 G / 4.

If D is positive, the first term is positive semidefinite, and the eigenvalues of A are at least minus the
norm of the sum of the second term and the symmetric part of dA.  This norm is at most the spectral radius of

    B = (gamma |L| |U| + |U|^T |L|^T gamma) / 2 + |G|^T D^-1 |G| / 4,

and hence at most ``max_i (B v)_i / v_i`` for any positive v (Collatz and Wielandt; Horn and Johnson, Matrix
analysis, 8.1.26): a few products with B give a good v.  Applied to A - s I, this bounds the eigenvalues of A
from below.  The idea is due to Rump (Verification of positive definiteness, BIT 46, 2006), who uses an a
priori bound on the error of Cholesky factorization, which would be some ten thousand times larger here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from isoembed.arrays import Floats, Indices
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.superlu import has_row_exchanges, symmetric_lu
from isoembed.proof.rounding import GUARD, UNDERFLOW, U

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU


POWER_ITERATIONS = 6  # products with the error bounds: more would gain a few percent
LEAST_ENTRY = 1e-3  # of the positive vector, relative to its largest entry
PROVEN_SHARE = 0.5  # of the estimated smallest eigenvalue, leaving a margin for rounding


@dataclass(frozen=True, eq=False)
class PositiveDefinite:
    """Symmetric matrix proven positive definite, with eigenvalues of at least `eigenvalue` > 0."""

    eigenvalue: float
    _lu: SuperLU
    _order: Indices

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b, shape (n,), approximately."""
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x


def smallest_eigenvalue(matrix: sp.csc_array) -> tuple[SuperLU, float]:
    """Factors of a symmetric matrix in its given order, and its smallest eigenvalue by inverse iteration."""
    lu = symmetric_lu(matrix)
    x = np.random.default_rng(0).normal(size=matrix.shape[0])
    for _ in range(12):  # the estimate exceeds the eigenvalue by n^(1/24) or so: 1.6 for 10^5
        x = lu.solve(x / np.linalg.norm(x))
    return lu, float(1 / np.linalg.norm(x))


def lost_to_rounding(matrix: sp.csc_array, shift: float) -> float:
    """Bound on the difference by which eigenvalues of a symmetric matrix may be below the shift.

    Raises
    ------
    SingularMatrix
        An eigenvalue is below the shift according to the computed pivots.
    """
    shifted = sp.csc_array(matrix - shift * sp.eye_array(matrix.shape[0], format="csc"))
    factors = Pivots.of(symmetric_lu(shifted))
    if factors.negative:
        raise SingularMatrix("the matrix is not positive definite, as far as floats tell")
    return factors.largest_error() + U * float(np.abs(shifted.diagonal()).max())


def hidden(estimate: float, rounding: float) -> SingularMatrix:
    """Exception for a matrix whose smallest eigenvalue is within the error bound."""
    return SingularMatrix(
        f"the matrix cannot be proven positive definite: its least eigenvalue is about {estimate:.1e}, "
        f"and rounding errors are up to {rounding:.1e}"
    )


@dataclass(frozen=True, eq=False)
class Pivots:
    """Factors without pivoting, with the quantities that bound their errors.

    Attributes
    ----------
    lower, upper : sparse CSC, (n, n)
        Absolute values of the entries of the factors.
    rest : sparse CSC, (n, n)
        Absolute values of ``G = U - D L^T``, rounded up.
    pivots : ndarray, shape (n,)
        D.
    relative : ndarray, shape (n,)
        Bounds gamma on the relative errors of the sums in each row.
    """

    lower: sp.csc_array
    upper: sp.csc_array
    rest: sp.csc_array
    pivots: Floats
    relative: Floats

    @classmethod
    def of(cls, lu: SuperLU) -> Pivots:
        """Take the factors of SuperLU; raises SingularMatrix if rows were exchanged or a pivot is zero."""
        upper = lu.U
        pivots = upper.diagonal()
        if has_row_exchanges(lu) or not (pivots != 0).all():  # an exchange avoids a pivot of zero
            raise SingularMatrix("the matrix is not positive definite, as far as floats tell")
        lower = lu.L
        # 6 roundings in addition to the terms of the sum for an entry
        roundings = np.bincount(lower.indices, minlength=pivots.size) + 6
        relative = roundings * U / (1 - roundings * U)
        rest = abs(upper - sp.diags_array(pivots) @ lower.T) + 4 * U * abs(upper)
        return cls(abs(lower), abs(upper), rest, pivots, relative)

    @property
    def negative(self) -> int:
        """Number of negative pivots."""
        return int((self.pivots < 0).sum())

    def errors(self, v: Floats) -> Floats:
        """Product of B with a positive vector, (n,)."""
        w = (
            self.relative * (self.lower @ (self.upper @ v))
            + self.upper.T @ (self.lower.T @ (self.relative * v))
        ) / 2
        return np.asarray(w + self.rest.T @ (self.rest @ v / np.abs(self.pivots)) / 4)

    def largest_error(self) -> float:
        """Upper bound on the spectral radius of B."""
        v, bound = np.ones(self.pivots.size), np.inf
        for _ in range(POWER_ITERATIONS):
            w = self.errors(v)
            bound = min(bound, float((w / v).max()))
            v = np.maximum(w / w.max(), LEAST_ENTRY)
        return bound * GUARD + UNDERFLOW
