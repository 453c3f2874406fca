"""Proof of full row rank of a sparse matrix in floating point, with a lower bound of its singular values.

The eigenvalues of ``A = J J^T`` are bounded from below as in `isoembed.proof.definite`.  Where rounding may
take more than the least of them, the few soft directions are treated on their own.  Let the m columns of V
be near the eigenvectors of the least eigenvalues; nu a number that rounding does not hide; and let

    K = [ A - nu    s V      ]
        [ s V^T    -s^2/tau I]

be factored without exchanges.  B being the bound of `definite` on the errors of the factors, which is no
larger than the diagonal matrix of (B v)_i / v_i for any positive v: K plus that matrix has no more negative
eigenvalues than there are negative pivots.  Let these be m at most, e the largest entry in the rows of A, and
the others less than s^2 / tau.  Then the border has m negative eigenvalues, and its Schur complement, which
is A - nu, plus e at most, plus a matrix that vanishes across V, has none.  So

    w . A w >= (nu - e) |w|^2    for all w orthogonal to V.

Let ``P = (J^T V)^T (J^T V)``, ``G = V^T V`` and ``R = A V - V H``, H being any matrix.  For x = V c + w

    x . (A - t) x >= c . (P - t G) c - 2 |w| |R c| + (nu - e - t) |w|^2,

which is nowhere negative if ``P - t G - R^T R / (nu - e - t)`` has no negative eigenvalue: A has none below
t.  J^T V is small, and known to many more digits than A V is: t may be far below what rounding takes from
the factors of A.  (On bounds by residuals see Parlett, The symmetric eigenvalue problem, 1998, chapter 10.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from isoembed.arrays import Floats, Indices
from isoembed.linalg.superlu import symmetric_lu
from isoembed.proof.definite import (
    LEAST_ENTRY,
    POWER_ITERATIONS,
    PROVEN_SHARE,
    Pivots,
    PositiveDefinite,
    hidden,
    least_eigenvalue,
    lost_to_rounding,
)
from isoembed.proof.rounding import GUARD, UNDERFLOW, U, gamma

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU


NU_FACTORS = (3.0, 2.7, 3.5, 4.0)  # nu over what rounding takes, tried in turn
LIFTED = 1.5  # eigenvalues up to this many nu have their vectors in V
VECTOR_COUNTS = (16, 32, 64, 128)  # eigenvectors computed, in turn


def prove_row_rank(J: sp.csr_array, order: Indices) -> tuple[PositiveDefinite, float]:
    """Bound the singular values of a matrix away from zero, (n, k), and factor J J^T.

    Parameters
    ----------
    J : sparse CSR, (n, k)
        What is proven holds for these floats.
    order : ndarray of int, shape (n,)
        Elimination order of the rows.

    Returns
    -------
    factor : PositiveDefinite
    sigma : float
        The n singular values are at least this.

    Raises
    ------
    SingularMatrix
        Rounding leaves no proof.
    """
    J = sp.csr_array(J[order])
    A = sp.csc_array(J @ J.T)
    lu, estimate = least_eigenvalue(A)
    shift = PROVEN_SHARE * estimate
    lost = lost_to_rounding(A, shift) + _forming(J)
    least = (shift - lost) / GUARD
    if not lost < shift:
        if estimate < 1e-4 * lost:  # so far below rounding that no proof is attempted
            raise hidden(estimate, lost)
        least = _Deflated.of(J, A, lu, lost).least_eigenvalue()
        if not least > 0:
            raise hidden(estimate, lost)
    return PositiveDefinite(least, lu, order), float(np.sqrt(least)) / GUARD


def _forming(J: sp.csr_array) -> float:
    """Bound on the effect of rounding on the eigenvalues of J J^T when it is formed."""
    sizes, n = abs(J), J.shape[0]
    terms = int(np.diff(J.indptr).max())
    return GUARD * gamma(terms + 2) * float((sizes @ (sizes.T @ np.ones(n))).max())


@dataclass(frozen=True, eq=False)
class _Deflated:
    """The soft directions V, (n, m), their eigenvalues, and a bound on A across them."""

    J: sp.csr_array
    V: Floats
    eigenvalues: Floats
    across: float

    @classmethod
    def of(cls, J: sp.csr_array, A: sp.csc_array, lu: SuperLU, lost: float) -> _Deflated:
        every, values = _soft(A, lu, LIFTED * max(NU_FACTORS) * lost)
        for clear in NU_FACTORS:  # a shift near an eigenvalue of a part of A makes large factors
            soft = values <= LIFTED * clear * lost
            V, eigenvalues = every[:, soft], values[soft]
            across = _across(A, V, clear * lost) - _forming(J)
            if across > 2 * eigenvalues.min():
                break
        return cls(J, V, eigenvalues, across)

    def least_eigenvalue(self) -> float:
        """Lower bound on the eigenvalues of J J^T; 0 if there is none."""
        (n, m), J, V = self.V.shape, self.J, self.V
        sizes, terms = abs(J), max(np.diff(J.indptr).max(), np.bincount(J.indices).max())
        relative = GUARD * gamma(int(terms) + 4)
        Y = J.T @ V
        P, G, R = Y.T @ Y, V.T @ V, J @ Y - V * self.eigenvalues
        off = relative * (sizes.T @ np.abs(V))  # of Y
        missed = relative * (sizes @ np.abs(Y) + np.abs(V * self.eigenvalues)) + sizes @ off
        residual = GUARD * float(np.linalg.norm(R) + np.linalg.norm(missed))
        size, far, width = (float(np.linalg.norm(each)) for each in (Y, off, V))
        sums = GUARD * gamma(max(n, J.shape[1]))
        for share in (0.9, 0.5, 0.2):  # of the least eigenvalue
            t = share * float(self.eigenvalues.min())
            if not self.across > 2 * t:
                continue
            M = P - t * G
            error = 2 * size * far + far**2 + sums * (size**2 + t * width**2)
            error += residual**2 / (self.across - t) + m * m * U * float(np.linalg.norm(M)) + UNDERFLOW
            if float(np.linalg.eigvalsh((M + M.T) / 2)[0]) > GUARD * error:
                return t / GUARD
        return 0.0


def _across(A: sp.csc_array, V: Floats, nu: float) -> float:
    """Lower bound, nu - e, on A across the columns of V; minus infinity if there is none."""
    n, m = V.shape
    s, diagonal = 2.0 ** np.round(np.log2(nu) / 2), 0.01  # 1 / tau, in nu
    W = s * V  # without rounding
    shifted = sp.csc_array(A - nu * sp.eye_array(n, format="csc"))
    K = sp.block_array([[shifted, W], [W.T, -diagonal * sp.eye_array(m)]], format="csc")
    factors = Pivots.of(symmetric_lu(K))
    if factors.negative > m:
        return -np.inf
    return nu - _interior_error(factors, n, diagonal) - U * float(np.abs(shifted.diagonal()).max())


def _soft(A: sp.csc_array, lu: SuperLU, most: float) -> tuple[Floats, Floats]:
    """Eigenvectors (n, m) with the eigenvalues (m,) up to `most`, or as many as are worth it."""
    from scipy.sparse.linalg import LinearOperator, eigsh  # slow to import

    n = A.shape[0]
    inverse = LinearOperator((n, n), matvec=lu.solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(n)
    for count in VECTOR_COUNTS:
        k = min(count, n - 1)
        values, vectors = eigsh(inverse, k=k, which="LA", v0=start, tol=1e-5)  # the vectors need few digits
        values = 1 / values
        if values.max() > most:
            break
    chosen = values <= most
    return vectors[:, chosen], values[chosen]


def _interior_error(factors: Pivots, n: int, border: float) -> float:
    """The number e, if a vector v leaves the border less than this; infinite if none does."""
    best = np.inf
    for share in (1.0, 0.1, 0.01, 1e-3):  # of v in the border
        v = np.ones(factors.pivots.size)
        for _ in range(POWER_ITERATIONS):
            v[n:] = share
            ratio = factors.errors(v) / v
            if GUARD * ratio[n:].max() + UNDERFLOW < border:
                best = min(best, GUARD * float(ratio[:n].max()) + UNDERFLOW)
            v = np.maximum(ratio * v / (ratio * v)[:n].max(), LEAST_ENTRY)
    return best
