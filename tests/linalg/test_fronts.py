"""Elimination in dense fronts, against NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.linalg import fronts
from isoembed.linalg.fronts import beginning, eliminate_columns, extend, room_to_multiply
from isoembed.threads import reserve_threads


def triangle(matrix):
    """The upper triangle, row after row."""
    return np.concatenate([matrix[j, j:] for j in range(len(matrix))])


def random_symmetric(m, seed, negative=0):
    """Diagonally dominant: as many eigenvalues are negative as entries of the diagonal."""
    rng = np.random.default_rng(seed)
    matrix = rng.uniform(-1, 1, (m, m))
    diagonal = rng.uniform(m, 2 * m, m)
    diagonal[rng.permutation(m)[:negative]] *= -1
    return np.triu(matrix, 1) + np.triu(matrix, 1).T + np.diag(diagonal)


def eliminated(matrix, k, least, precision=np.float64):
    """The front after k columns are eliminated, and whether that went well."""
    m = len(matrix)
    front = triangle(matrix).astype(precision)
    done = eliminate_columns(front, k, m, least, np.empty(room_to_multiply(k, m), dtype=precision))
    return front, done


@pytest.mark.parametrize(
    ("m", "k"),
    [
        (1, 1),
        (2, 1),
        (5, 3),
        (9, 4),
        (9, 9),
        (30, 13),
        (80, 16),
        (81, 16),
        (520, 300),
        (140, 66),
        (150, 150),
        (700, 300),
    ],
)
@pytest.mark.parametrize(("negative", "precision"), [(0, np.float64), (1, np.float64), (0, np.float32)])
def test_rows_and_what_is_left_are_those_of_dense_elimination(m, k, negative, precision):
    matrix = random_symmetric(m, 10 * m + k, negative)
    front, done = eliminated(matrix, k, -np.inf, precision)
    assert done and front.dtype == precision
    error = m * (1e-11 if precision == np.float64 else 1e-6)
    left = matrix[k:, k:] - matrix[k:, :k] @ np.linalg.solve(matrix[:k, :k], matrix[:k, k:])
    np.testing.assert_allclose(front[beginning(k, m) :], triangle(left) if k < m else [], atol=error)
    L, D = np.zeros((m, k)), np.zeros(k)
    for j in range(k):
        row = front[beginning(j, m) : beginning(j + 1, m)]
        D[j], L[j:, j] = row[0], row / row[0]
    np.testing.assert_allclose((L * D) @ L[:k].T, matrix[:, :k], atol=error)


def test_products_have_the_same_bits_for_any_number_of_threads():
    matrix = random_symmetric(700, 0)
    found = []
    for count in (1, 2, 3):
        with reserve_threads(count):
            found.append(eliminated(matrix, 600, 0.0)[0])
    np.testing.assert_array_equal(found[1:], found[:1] * 2)


def test_errors_in_threads_are_raised(monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(fronts, "run_ranges", fail)
    for k in (256, 400):  # in a part of the columns, and after all of them
        with pytest.raises(MemoryError):
            eliminated(random_symmetric(1200 if k == 256 else 700, 0), k, 0.0)


@given(st.integers(2, 12), st.integers(0, 10**6))
def test_a_pivot_that_is_not_positive_is_refused_where_it_must_be(m, seed):
    matrix = random_symmetric(m, seed, 1)
    assert not eliminated(matrix, m, 0.0)[1]
    assert eliminated(matrix, m, -np.inf)[1]
    matrix[:] = matrix[0, 0]
    assert not eliminated(matrix, m, -np.inf)[1]  # the second pivot is zero
    matrix[-1, -1] = np.nan
    assert not eliminated(matrix, m, -np.inf)[1]


@given(st.integers(1, 8), st.integers(0, 8), st.integers(0, 10**6))
def test_what_is_passed_on_is_added_in_its_place(size, more, seed):
    rng = np.random.default_rng(seed)
    m = size + more
    places = np.sort(rng.permutation(m)[:size])
    matrix, passed = random_symmetric(m, seed), random_symmetric(size, seed + 1)
    front = triangle(matrix)
    extend(front, m, triangle(passed), places)
    matrix[np.ix_(places, places)] += passed
    assert np.array_equal(front, triangle(matrix))
