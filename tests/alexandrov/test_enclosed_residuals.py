"""Residuals to twice the digits of floats, against fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.alexandrov.enclosed_residuals import enclosed_residuals


def exact(edges, vertices, corrections, lengths):
    x = [[Fraction(v) + Fraction(c) for v, c in zip(*rows, strict=True)]
         for rows in zip(vertices, corrections, strict=True)]  # fmt: skip
    found = []
    for (a, b), length in zip(edges, lengths, strict=True):
        square = sum((p - q) ** 2 for p, q in zip(x[a], x[b], strict=True))
        found.append((square - Fraction(length) ** 2) / (2 * Fraction(length)))
    return found


def case(seed, offset, correction):
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(8, 3)) + offset
    corrections = correction * rng.normal(size=(8, 3))
    edges = np.array([(a, b) for a in range(8) for b in range(a)])
    d = vertices[edges[:, 0]] - vertices[edges[:, 1]]
    return edges, vertices, corrections, np.linalg.norm(d, axis=1)


@given(
    st.integers(0, 10**6),
    st.sampled_from([0.0, 1.0, 1e3, 1e8]),
    st.sampled_from([0.0, 1e-16, 1e-13, 1e-8, 1e-3]),
)
def test_the_exact_residuals_are_within_the_errors(seed, offset, correction):
    given_case = case(seed, offset, correction)
    values, errors = enclosed_residuals(*given_case)
    for value, error, truth in zip(values, errors, exact(*given_case), strict=True):
        assert abs(Fraction(value) - truth) <= Fraction(error)


@pytest.mark.parametrize("correction", [0.0, 1e-13])
def test_the_errors_are_far_below_those_of_floats(correction):
    values, errors = enclosed_residuals(*case(1, 0.0, correction))
    assert np.abs(values).max() > 1e-17
    assert errors.max() < 1e-28 + 5e-15 * np.abs(values).max()


def test_lengths_of_floats_that_are_exact_have_no_residual():
    vertices = np.array([[0.0, 0, 0], [3.0, 4.0, 0.0], [2.0, 3.0, 6.0]])
    edges = np.array([[0, 1], [0, 2]])
    values, errors = enclosed_residuals(edges, vertices, np.zeros((3, 3)), np.array([5.0, 7.0]))
    assert values.tolist() == [0.0, 0.0]
    assert errors.max() < 1e-28
