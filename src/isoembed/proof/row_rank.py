"""Proof of full row rank of a sparse matrix in floating point, with a lower bound on its singular values.

The eigenvalues of ``A = J J^T`` are bounded from below as in `isoembed.proof.definite`.  If the error bound
exceeds the smallest eigenvalue, the few soft directions are treated separately (deflation).  Let the m
columns of V approximate the eigenvectors of the smallest eigenvalues; nu be a number above the error bound;
and let

    K = [ A - nu    s V      ]
        [ s V^T    -s^2/tau I]

be factored without pivoting.  Let B be the bound of `definite` on the errors of the factors, which is at most
the diagonal matrix of (B v)_i / v_i for any positive v: K plus that matrix has at most as many negative
eigenvalues as there are negative pivots.  Let there be at most m of these, let e be the largest of its
entries in the rows of A, and the others less than s^2 / tau.  Then the border has m negative eigenvalues, and
its Schur complement, which is A - nu, plus at most e, plus a matrix that vanishes orthogonally to V, has
none.  So

    w . A w >= (nu - e) |w|^2    for all w orthogonal to V.

Let ``P = (J^T V)^T (J^T V)``, ``G = V^T V`` and ``R = A V - V H`` for any matrix H.  For x = V c + w

    x . (A - t) x >= c . (P - t G) c - 2 |w| |R c| + (nu - e - t) |w|^2,

which is nonnegative if ``P - t G - R^T R / (nu - e - t)`` has no negative eigenvalue: then A has none below
t.  J^T V is small, and known much more accurately than A V: t may be far below the error bound of the factors
of A.  (On residual bounds see Parlett, The symmetric eigenvalue problem, 1998, chapter 10.)
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
    lost_to_rounding,
    smallest_eigenvalue,
)
from isoembed.proof.rounding import GUARD, UNDERFLOW, U, gamma

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU


NU_FACTORS = (3.0, 2.7, 3.5, 4.0)  # nu relative to the error bound, tried in turn
LIFTED = 1.5  # V contains the eigenvectors for eigenvalues up to this multiple of nu
VECTOR_COUNTS = (16, 32, 64, 128)  # numbers of computed eigenvectors, tried in turn


def prove_row_rank(J: sp.csr_array, order: Indices) -> tuple[PositiveDefinite, float]:
    """Bound the singular values of a matrix J, (n, k), away from zero, and factor J J^T.

    Parameters
    ----------
    J : sparse CSR, (n, k)
        Matrix, with its floats taken as exact.
    order : ndarray of int, shape (n,)
        Elimination order of the rows.

    Returns
    -------
    factor : PositiveDefinite
    sigma : float
        Lower bound on the n singular values.

    Raises
    ------
    SingularMatrix
        Rounding leaves no proof.
    """
    J = sp.csr_array(J[order])
    A = sp.csc_array(J @ J.T)
    lu, estimate = smallest_eigenvalue(A)
    shift = PROVEN_SHARE * estimate
    rounding = lost_to_rounding(A, shift) + _forming(J)
    lower = (shift - rounding) / GUARD
    if not rounding < shift:
        if estimate < 1e-4 * rounding:  # too far below the error bound for a proof
            raise hidden(estimate, rounding)
        lower = _Deflated.of(J, A, lu, rounding).smallest_eigenvalue()
        if not lower > 0:
            raise hidden(estimate, rounding)
    return PositiveDefinite(lower, lu, order), float(np.sqrt(lower)) / GUARD


def _forming(J: sp.csr_array) -> float:
    """Bound on the eigenvalue errors of J J^T due to rounding in its formation."""
    sizes, n = abs(J), J.shape[0]
    terms = int(np.diff(J.indptr).max())
    return GUARD * gamma(terms + 2) * float((sizes @ (sizes.T @ np.ones(n))).max())


@dataclass(frozen=True, eq=False)
class _Deflated:
    """Soft directions V, (n, m), their eigenvalues, and a lower bound on A orthogonally to them."""

    J: sp.csr_array
    V: Floats
    eigenvalues: Floats
    across: float

    @classmethod
    def of(cls, J: sp.csr_array, A: sp.csc_array, lu: SuperLU, rounding: float) -> _Deflated:
        every, values = _soft(A, lu, LIFTED * max(NU_FACTORS) * rounding)
        for clear in NU_FACTORS:  # a shift near an eigenvalue of a submatrix of A causes large factors
            soft = values <= LIFTED * clear * rounding
            V, eigenvalues = every[:, soft], values[soft]
            across = _across(A, V, clear * rounding) - _forming(J)
            if across > 2 * eigenvalues.min():
                break
        return cls(J, V, eigenvalues, across)

    def smallest_eigenvalue(self) -> float:
        """Lower bound on the eigenvalues of J J^T; 0 if there is none."""
        (n, m), J, V = self.V.shape, self.J, self.V
        sizes, terms = abs(J), max(np.diff(J.indptr).max(), np.bincount(J.indices).max())
        relative = GUARD * gamma(int(terms) + 4)
        Y = J.T @ V
        P, G, R = Y.T @ Y, V.T @ V, J @ Y - V * self.eigenvalues
        off = relative * (sizes.T @ np.abs(V))  # error of Y
        residuals = relative * (sizes @ np.abs(Y) + np.abs(V * self.eigenvalues)) + sizes @ off
        residual = GUARD * float(np.linalg.norm(R) + np.linalg.norm(residuals))
        size, far, width = (float(np.linalg.norm(each)) for each in (Y, off, V))
        sums = GUARD * gamma(max(n, J.shape[1]))
        for share in (0.9, 0.5, 0.2):  # of the smallest eigenvalue
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
    """Lower bound, nu - e, on A orthogonally to the columns of V; minus infinity if there is none."""
    n, m = V.shape
    s, diagonal = 2.0 ** np.round(np.log2(nu) / 2), 0.01  # 1 / tau, in nu
    W = s * V  # without rounding
    shifted = sp.csc_array(A - nu * sp.eye_array(n, format="csc"))
    K = sp.block_array([[shifted, W], [W.T, -diagonal * sp.eye_array(m)]], format="csc")
    factors = Pivots.of(symmetric_lu(K))
    if factors.negative > m:
        return -np.inf
    return nu - _interior_error(factors, n, diagonal) - U * float(np.abs(shifted.diagonal()).max())


def _soft(A: sp.csc_array, lu: SuperLU, cutoff: float) -> tuple[Floats, Floats]:
    """Eigenvectors (n, m) and eigenvalues (m,) up to `cutoff`, limited by `VECTOR_COUNTS`."""
    from scipy.sparse.linalg import LinearOperator, eigsh  # slow to import

    n = A.shape[0]
    inverse = LinearOperator((n, n), matvec=lu.solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(n)
    for count in VECTOR_COUNTS:
        k = min(count, n - 1)
        values, vectors = eigsh(inverse, k=k, which="LA", v0=start, tol=1e-5)  # the vectors need few digits
        values = 1 / values
        if values.max() > cutoff:
            break
    chosen = values <= cutoff
    return vectors[:, chosen], values[chosen]


def _interior_error(factors: Pivots, n: int, border: float) -> float:
    """Number e for a vector v with entries less than `border` in the border; infinite if none is found."""
    best = np.inf
    for share in (1.0, 0.1, 0.01, 1e-3):  # entries of v in the border
        v = np.ones(factors.pivots.size)
        for _ in range(POWER_ITERATIONS):
            v[n:] = share
            ratio = factors.errors(v) / v
            if GUARD * ratio[n:].max() + UNDERFLOW < border:
                best = min(best, GUARD * float(ratio[:n].max()) + UNDERFLOW)
            v = np.maximum(ratio * v / (ratio * v)[:n].max(), LEAST_ENTRY)
    return best
