"""Multifrontal factors of random sparse matrices, against NumPy and other libraries."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from grids import grid
from isoembed.linalg import analyze, factor
from isoembed.linalg.superlu import symmetric_lu
from patterns import random_pattern


def random_matrix(n, density, definite, rng):
    """Dominated by its diagonal, so that it has accurate factors in any order."""
    matrix = np.where(random_pattern(n, density, rng), rng.uniform(-1, 1, (n, n)), 0)
    matrix = np.triu(matrix, 1) + np.triu(matrix, 1).T
    signs = np.ones(n) if definite else rng.choice([-1, 1], n)
    return matrix + np.diag(signs * (1 + np.abs(matrix).sum(axis=1)))


@given(st.integers(1, 40), st.floats(0.0, 0.5), st.booleans(), st.integers(0, 10**6))
def test_random_sparse_matrices(n, density, definite, seed):
    rng = np.random.default_rng(seed)
    matrix, order, b = random_matrix(n, density, definite, rng), rng.permutation(n), rng.normal(size=(n, 3))
    csc = sp.csc_array(matrix)
    factors = analyze(csc, order, definite=definite).factor(csc.data)
    exact = np.linalg.solve(matrix, b)
    for sweeps in (0, 2):
        np.testing.assert_allclose(factors.solve(b, sweeps), exact, atol=1e-13)
        np.testing.assert_allclose(factors.solve(b[:, 1], sweeps), exact[:, 1], atol=1e-13)
    assert factors.negative_pivots == int((np.linalg.eigvalsh(matrix) < 0).sum())


@pytest.mark.parametrize("shift", [0.0, 1.2])
def test_factors_in_single_precision_precondition(monkeypatch, shift):
    monkeypatch.setattr(factor, "SINGLE_ENTRIES", 0)
    matrix, order = shifted(40, shift)
    b = np.random.default_rng(0).normal(size=(1600, 2))
    solver = analyze(matrix, order, definite=not shift)
    x = solver.factor(matrix.data).solve(b)
    single = solver.factor(matrix.data, single=True)
    assert 1e-9 < np.abs(single.solve(b, sweeps=0) - x).max() / np.abs(x).max() < 1e-5
    np.testing.assert_allclose(single.solve(b), x, rtol=0, atol=1e-11 * np.abs(x).max())
    if shift:  # iterations that are preconditioned with these factors go on to full accuracy
        halves = single.solve(b, sweeps=0) + single.solve(b[:, ::-1], sweeps=0)
        both = single.solve(b + b[:, ::-1], sweeps=0)
        np.testing.assert_allclose(both, halves, rtol=0, atol=1e-12 * np.abs(both).max())
    scales = np.array([2.0**-300, 2.0**300])  # beyond the range of single precision
    scaled = single.solve(b * scales, sweeps=0) / scales
    np.testing.assert_array_equal(scaled, single.solve(b, sweeps=0))


def shifted(side, shift):
    """A Laplacian of a grid, less a multiple of the identity, and an order."""
    matrix, order = grid(side)
    return sp.csc_matrix(matrix - shift * sp.eye_array(side**2)), order


@pytest.mark.parametrize("shift", [0.0, 1.2])
def test_superlu_gives_the_same(shift):
    matrix, order = shifted(50, shift)
    b = np.random.default_rng(0).normal(size=(2500, 2))
    ours = analyze(matrix, order, definite=not shift).factor(matrix.data)
    theirs = symmetric_lu(matrix[order][:, order].tocsc())
    assert ours.negative_pivots == int((theirs.U.diagonal() < 0).sum())
    x = np.empty_like(b)
    x[order] = theirs.solve(b[order])
    np.testing.assert_allclose(ours.solve(b), x, rtol=0, atol=1e-9 * np.abs(x).max())


@pytest.mark.parametrize("shift", [0.0, 1.2])
def test_pardiso_gives_the_same(shift):
    pardiso = pytest.importorskip("pypardiso")
    matrix, order = shifted(50, shift)
    b = np.random.default_rng(0).normal(size=(2500, 2))
    x = pardiso.spsolve(sp.csr_matrix(matrix), b)
    ours = analyze(matrix, order, definite=not shift).factor(matrix.data)
    np.testing.assert_allclose(ours.solve(b), x, rtol=0, atol=1e-9 * np.abs(x).max())


def test_cholmod_gives_the_same():
    cholmod = pytest.importorskip("sksparse.cholmod")
    matrix, order = shifted(50, 0.0)
    b = np.random.default_rng(0).normal(size=2500)
    theirs = cholmod.cholesky(matrix)
    np.testing.assert_allclose(analyze(matrix, order).factor(matrix.data).solve(b), theirs(b), atol=1e-11)


def test_relabelling_changes_nothing():
    matrix, order = shifted(12, 1.3)
    names = np.random.default_rng(0).permutation(144)
    relabelled, place = sp.csc_matrix(matrix[names][:, names]), np.argsort(names)
    relabelled.sort_indices()
    b = np.random.default_rng(1).normal(size=144)
    x = analyze(matrix, order, definite=False).factor(matrix.data).solve(b, 0)
    y = analyze(relabelled, place[order], definite=False).factor(relabelled.data).solve(b[names], 0)
    assert np.array_equal(y, x[names])
