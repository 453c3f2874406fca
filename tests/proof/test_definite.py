"""Proofs that matrices are positive definite: against exact elimination in fractions, and refusals."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

import zoo
from definite import prove_definite
from isoembed.linalg import SingularMatrix, dissect
from isoembed.linalg.superlu import symmetric_lu
from isoembed.mesh.triangulation import Triangulation
from isoembed.proof.definite import Pivots


def exactly_definite(matrix):
    """Whether elimination in fractions meets positive pivots only."""
    rows = [[Fraction(value) for value in row] for row in matrix]
    for k in range(len(rows)):
        if rows[k][k] <= 0:
            return False
        for i in range(k + 1, len(rows)):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return True


def random_definite(n, seed, decades=3.0):
    """Symmetric, with a diagonal near 1 and eigenvalues over so many decades."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    matrix = (q * 10.0 ** -rng.uniform(0, decades, n)) @ q.T
    return (matrix + matrix.T) / 2


def laplacian(n, seed):
    """Of the graph of a hull: singular, with small integers as entries, which floats hold exactly."""
    triangulation = Triangulation(zoo.random_hull(n, seed)[1])
    L = sp.diags_array(triangulation.degrees.astype(float)) - triangulation.adjacency
    return sp.csc_array(L), dissect(triangulation.adjacency).vertex_order()


@given(st.integers(0, 10**6), st.integers(2, 9))
def test_the_bound_holds_in_fractions_and_is_half_of_the_eigenvalue(seed, n):
    matrix = random_definite(n, seed)
    bound = prove_definite(sp.csc_array(matrix), np.arange(n)).eigenvalue
    least = np.linalg.eigvalsh(matrix)[0]
    shifted = [[Fraction(a) - (i == j) * Fraction(bound) for j, a in enumerate(matrix[i])] for i in range(n)]
    assert exactly_definite(shifted)
    assert 0.45 * least < bound < least


@given(st.integers(0, 10**6))
def test_eigenvalues_are_no_farther_below_zero_than_is_said(seed):
    matrix = random_definite(6, seed, decades=6.0)
    bound = Pivots.of(symmetric_lu(sp.csc_array(matrix))).largest_error()
    least = np.linalg.eigvalsh(matrix)[0]
    raised = [[Fraction(a) + (i == j) * Fraction(bound) for j, a in enumerate(matrix[i])] for i in range(6)]
    assert least > 0 or exactly_definite(raised)
    assert bound < 1e-13


@pytest.mark.parametrize("n", [12, 300])
def test_a_sparse_matrix(n):
    matrix, order = laplacian(n, 1)
    matrix = sp.csc_array(matrix + 0.01 * sp.eye_array(n))
    proven = prove_definite(matrix, order)
    assert 0.0049 < proven.eigenvalue <= 0.01
    b = np.random.default_rng(0).normal(size=n)
    assert matrix @ proven.solve(b) == pytest.approx(b, abs=1e-11)


def test_a_multiple_eigenvalue_is_no_trouble():
    bound = prove_definite(sp.csc_array(1e-3 * sp.eye_array(500)), np.arange(500)).eigenvalue
    assert bound == pytest.approx(0.5e-3, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_a_singular_matrix_is_not_proven(seed):
    with pytest.raises(SingularMatrix):
        prove_definite(*laplacian(100, seed))


def test_what_rounding_could_have_made_definite_is_not_proven():
    matrix, order = laplacian(100, 0)
    matrix = sp.csc_array(matrix + 1e-14 * sp.eye_array(100))
    with pytest.raises(
        SingularMatrix, match=r"least eigenvalue is about \d\.\de-1\d, and rounding errors are up to"
    ):
        prove_definite(matrix, order)


@pytest.mark.parametrize("negative", [-1e-3, -1e-9])
def test_an_indefinite_matrix_is_not_proven(negative):
    matrix = sp.csc_array(np.diag([1.0, 2.0, negative, 3.0]))
    with pytest.raises(SingularMatrix, match="not positive definite"):
        prove_definite(matrix, np.arange(4))


def test_a_pivot_of_zero():
    with pytest.raises(SingularMatrix, match="zero pivot"):
        prove_definite(sp.csc_array(np.array([[1.0, 1.0], [1.0, 1.0]])), np.arange(2))
