"""GMRES that counts, and conjugate gradients: exact solutions, honest residuals, no product too many."""

import numpy as np
import pytest

from isoembed.linalg.krylov import conjugate_gradients, gmres


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


def definite(n, seed):
    Q = np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0]
    return Q @ np.diag(np.geomspace(1, 1e3, n)) @ Q.T


def test_conjugate_gradients_solve_to_the_tolerance_and_say_how_far_they_came():
    A, b = definite(40, 0), np.arange(40.0)
    for tolerance in (1e-2, 1e-6, 1e-10):
        found = conjugate_gradients(lambda v: A @ v, lambda v: v / np.diag(A), b, tolerance, 200)
        residual = np.linalg.norm(A @ found.x - b) / np.linalg.norm(b)
        assert found.residual <= tolerance
        assert found.residual == pytest.approx(residual, rel=1e-3)


def test_k_eigenvalues_take_k_iterations():
    A = np.diag([1.0] * 5 + [3.0] * 5 + [10.0] * 5)
    found = conjugate_gradients(lambda v: A @ v, lambda v: v, np.arange(1.0, 16.0), 1e-12, 100)
    assert found.iterations == 3


def test_an_exact_preconditioner_needs_one_direction():
    A, b = definite(30, 1), np.ones((10, 3))
    shaped = [lambda v, M=M: (M @ v.ravel()).reshape(v.shape) for M in (A, np.linalg.inv(A))]
    found = conjugate_gradients(*shaped, b, 1e-10, 50)
    assert found.iterations == 1
    assert shaped[0](found.x) == pytest.approx(b, abs=1e-9)


def test_a_singular_matrix_gives_the_solution_of_least_norm():
    B = np.random.default_rng(2).normal(size=(6, 9))
    A, b = B.T @ B, B.T @ np.arange(6.0)
    found = conjugate_gradients(lambda v: A @ v, lambda v: v, b, 1e-12, 50)
    assert found.x == pytest.approx(np.linalg.pinv(B) @ np.arange(6.0), abs=1e-9)


def test_conjugate_gradients_stop_at_the_most_and_where_rounding_rules():
    A, b = definite(40, 3), np.ones(40)
    assert conjugate_gradients(lambda v: A @ v, lambda v: v, b, 0.0, 7).iterations == 7
    # What no direction can reduce: the right-hand side is not in the range.
    found = conjugate_gradients(lambda v: 0.0 * v, lambda v: v, b, 1e-10, 50)
    assert (found.iterations, found.residual) == (0, 1.0)


def test_conjugate_gradients_give_up_when_they_are_too_slow():
    A, b = np.diag(np.geomspace(1.0, 30.0, 60)), np.ones(60)

    def solved(most):
        return conjugate_gradients(lambda v: A @ v, lambda v: v, b, 1e-8, most, patience=4)

    assert solved(20).iterations == 4
    found = solved(100)
    assert found.residual <= 1e-8 and found.iterations > 20


def test_zero_needs_no_direction():
    found = conjugate_gradients(lambda v: v, lambda v: v, np.zeros(4), 1e-10, 5)
    assert found.iterations == 0 and found.residual == 0 and not found.x.any()
