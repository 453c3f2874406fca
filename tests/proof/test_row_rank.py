"""Proofs that matrices have full row rank, also where rounding hides their least singular values."""

import numpy as np
import pytest
import scipy.sparse as sp

from definite import prove_definite
from isoembed.linalg import SingularMatrix
from isoembed.proof import row_rank
from isoembed.proof.row_rank import prove_row_rank


def differences(n, power):
    """Differences of this order, (n, n + power): the k-th singular value is near (pi k / n)^power."""
    J = sp.eye_array(n + power, format="csr")
    for _ in range(power):
        J = sp.csr_array(J[1:] - J[:-1])
    return J, np.arange(n)


@pytest.mark.parametrize(("n", "power"), [(50, 1), (200, 2), (400, 3), (250, 4)])
def test_the_bound_is_near_the_least_singular_value(n, power):
    J, order = differences(n, power)
    factor, sigma = prove_row_rank(J, order)
    exact = np.linalg.svd(J.toarray(), compute_uv=False)[-1]
    assert 0.4 * exact < sigma < exact * (1 + 1e-6)
    assert factor.eigenvalue == pytest.approx(sigma**2)


def test_soft_directions_are_treated_on_their_own():
    # Rounding in the factors takes more than the least eigenvalue.
    J, order = differences(1000, 3)
    A = sp.csc_array(J @ J.T)
    with pytest.raises(SingularMatrix):
        prove_definite(A, order)
    assert prove_row_rank(J, order)[1] > 0.4 * np.linalg.svd(J.toarray(), compute_uv=False)[-1]


def test_order_does_not_matter():
    J, order = differences(300, 3)
    turned = order[::-1]
    assert prove_row_rank(J, turned)[1] == pytest.approx(prove_row_rank(J, order)[1], rel=1e-2)


def singular(rows=40):
    """Differences and their sum."""
    J = differences(rows, 1)[0]
    return sp.csr_array(sp.vstack([J, sp.csr_array(J.sum(axis=0)[None])])), np.arange(rows + 1)


def test_what_is_singular_is_not_proven():
    with pytest.raises(SingularMatrix):
        prove_row_rank(*singular())


def test_more_soft_directions_than_are_asked_for(monkeypatch):
    twice = sp.csr_array(sp.block_diag([differences(820, 3)[0]] * 2)), np.arange(1640)
    assert prove_row_rank(*twice)[1] > 0
    monkeypatch.setattr(row_rank, "VECTOR_COUNTS", (1,))
    with pytest.raises(SingularMatrix, match=r"least eigenvalue is about .*, and rounding errors are up to"):
        prove_row_rank(*twice)


def test_vectors_that_are_not_soft_prove_nothing(monkeypatch):
    def wrong(A, *_):
        return np.eye(A.shape[0])[:, :3], np.full(3, 1e-16)

    monkeypatch.setattr(row_rank, "_soft", wrong)
    with pytest.raises(SingularMatrix):
        prove_row_rank(*differences(1000, 3))
