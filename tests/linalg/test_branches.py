"""Branches of the elimination tree, on any number of threads: the same bits, and the answers of NumPy."""

import multiprocessing

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from grids import grid
from isoembed.linalg import SingularMatrix, analyze, branches
from isoembed.linalg.elimination import permuted, symbolic_analysis
from isoembed.linalg.supernodes import find_supernodes
from isoembed.linalg.threads import in_threads, thread_count
from patterns import random_pattern


@pytest.fixture(autouse=True)
def small_branches(monkeypatch):
    monkeypatch.setattr(branches, "LEAST", 0.0)


@pytest.mark.parametrize("shift", [0.0, 1.3])
def test_the_bits_do_not_depend_on_the_number_of_threads(monkeypatch, shift):
    matrix, order = grid(60)
    matrix = sp.csc_matrix(matrix - shift * sp.eye_array(3600))
    b = np.random.default_rng(0).normal(size=(3600, 3))
    solver = analyze(matrix, order, definite=not shift)
    assert len(solver._fronts._branches) >= 4
    found = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        factors = solver.factor(matrix.data)
        found.append((factors.negative_pivots, factors.solve(b, 0).tobytes(), factors.solve(b).tobytes()))
    assert found[0] == found[1] == found[2]
    monkeypatch.setattr(branches, "LEAST", np.inf)
    whole = analyze(matrix, order, definite=not shift).factor(matrix.data)
    assert whole.negative_pivots == found[0][0]
    x = whole.solve(b)
    np.testing.assert_allclose(factors.solve(b), x, rtol=0, atol=1e-12 * np.abs(x).max())


@given(st.integers(2, 40), st.floats(0.0, 0.4), st.booleans(), st.integers(0, 10**6))
def test_random_matrices(n, density, definite, seed):
    rng = np.random.default_rng(seed)
    matrix = np.where(random_pattern(n, density, rng), rng.uniform(-1, 1, (n, n)), 0)
    matrix = np.triu(matrix, 1) + np.triu(matrix, 1).T
    signs = np.ones(n) if definite else rng.choice([-1, 1], n)
    matrix += np.diag(signs * (1 + np.abs(matrix).sum(axis=1)))
    csc, b = sp.csc_array(matrix), rng.normal(size=(n, 2))
    factors = analyze(csc, rng.permutation(n), definite=definite).factor(csc.data)
    np.testing.assert_allclose(factors.solve(b, 0), np.linalg.solve(matrix, b), atol=1e-12)
    assert factors.negative_pivots == int((np.linalg.eigvalsh(matrix) < 0).sum())


def test_every_column_and_every_entry_belongs_to_one_part():
    matrix, order = grid(40)
    elimination = symbolic_analysis(matrix.indptr, matrix.indices, order)
    lower = permuted(matrix.indptr, matrix.indices, elimination.order, True)
    nodes = find_supernodes(matrix.indptr, matrix.indices, elimination)
    found, top = branches.cut(nodes, *lower[:2])
    columns = np.concatenate([np.arange(1600)[part.columns] for part in (*found, top)])
    entries = np.concatenate([np.arange(len(lower[1]))[part.entries] for part in (*found, top)])
    assert np.array_equal(np.sort(columns), np.arange(1600))
    assert np.array_equal(np.sort(entries), np.arange(len(lower[1])))
    assert sum(part.nodes.entries for part in (*found, top)) == nodes.entries
    for branch in found:
        # Nothing beyond the branch but rows of the top, which come later.
        assert (np.diff(branch.beyond) > 0).all()
        assert np.all(top.columns[branch.beyond] >= branch.columns.stop)


def test_a_branch_that_has_no_factors_is_refused(monkeypatch):
    matrix, order = grid(40)
    solver = analyze(matrix, order)
    inside = int(order[3])  # early: in a branch
    for threads in ("1", "3"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        for k in (inside, int(order[-1])):
            broken = matrix.copy()
            broken[k, k] = 0.1
            with pytest.raises(SingularMatrix, match="not positive definite"):
                solver.factor(broken.data)


def _count(_: int) -> int:
    return thread_count()


def test_threads_are_counted_as_libraries_count_them(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert thread_count() == 3
    monkeypatch.setenv("OMP_NUM_THREADS", "none")
    assert thread_count() >= 1
    monkeypatch.delenv("OMP_NUM_THREADS")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.map(_count, [0]) == [1]


def test_what_fails_in_a_thread_fails(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    assert in_threads(lambda k: k * k, range(5)) == [0, 1, 4, 9, 16]
    with pytest.raises(ZeroDivisionError):
        in_threads(lambda k: 1 // k, [1, 0, 2])
