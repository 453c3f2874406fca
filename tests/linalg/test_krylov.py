"""GMRES that counts: exact solutions, and no more products than iterations."""

import numpy as np
import pytest

from isoembed.linalg.krylov import gmres


def matrix(n, seed):
    rng = np.random.default_rng(seed)
    return np.diag(rng.uniform(1, 2, n)) + 0.1 * rng.normal(size=(n, n)) / np.sqrt(n)


def test_it_solves_and_counts():
    A, calls = matrix(50, 0), []

    def apply(v):
        calls.append("A")
        return A @ v

    def precondition(v):
        calls.append("M")
        return v / np.diag(A)

    b = np.arange(50.0)
    x, iterations = gmres(apply, precondition, b, 1e-10, 30)
    assert np.linalg.norm(A @ x - b) <= 1.1e-10 * np.linalg.norm(b)
    assert 3 < iterations < 20
    assert calls == ["M", "A"] * iterations


def test_an_exact_preconditioner_needs_one_iteration():
    A = matrix(20, 1)
    x, iterations = gmres(lambda v: A @ v, lambda v: np.linalg.solve(A, v), np.ones(20), 1e-12, 10)
    assert iterations == 1
    assert A @ x == pytest.approx(np.ones(20), abs=1e-12)


def test_the_preconditioner_may_change():
    A, count = matrix(30, 2), iter(range(100))
    x, _ = gmres(lambda v: A @ v, lambda v: v / (1 + 0.1 * next(count)), np.ones(30), 1e-10, 29)
    assert A @ x == pytest.approx(np.ones(30), abs=1e-9)


def test_it_stops_at_the_most_and_returns_the_best():
    A, b = matrix(50, 3), np.ones(50)
    x, iterations = gmres(lambda v: A @ v, lambda v: v, b, 1e-14, 3)
    assert iterations == 3
    assert 0 < np.linalg.norm(A @ x - b) < 0.1 * np.linalg.norm(b)


def test_zero_is_solved_by_zero():
    x, iterations = gmres(lambda v: v, lambda v: v, np.zeros(4), 1e-10, 5)
    assert iterations == 0 and not x.any()
