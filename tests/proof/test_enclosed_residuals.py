"""Residuals to twice the digits of floats, against fractions."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed import Space
from isoembed.proof.enclosed_residuals import enclosed_residuals, squared_chords
from isoembed.space.models import from_model


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


def exact_squared_chord(length, k):
    """By fifty terms of its series: those that are left are below 1e-40 of it."""
    square, total = Fraction(length) ** 2, Fraction(0)
    for n in range(50, -1, -1):
        total = total * -Fraction(k) * square + Fraction(2, factorial(2 * n + 2))
        total = Fraction(round(total * 2**400), 2**400)
    return square * total


CURVATURES = [-1.0, -0.3, -1e-9, -1e-20, 0.7, 4.0]


@pytest.mark.parametrize("k", CURVATURES)
def test_squared_chords(k):
    longest = {-1.0: 10.0, 0.7: 3.7, 4.0: 1.57}.get(k, 5.0)
    lengths = np.random.default_rng(0).uniform(0.0, longest, 20)
    _, (high, low), off = squared_chords(lengths, k)
    for i, length in enumerate(lengths):
        error = abs(Fraction(high[i]) + Fraction(low[i]) - exact_squared_chord(length, k))
        assert error <= Fraction(off[i]) * Fraction(2) ** -106
        assert off[i] < 1e6 * high[i]


@pytest.mark.parametrize("k", CURVATURES)
@pytest.mark.parametrize("correction", [0.0, 1e-16, 1e-12, 1e-5])
def test_residuals_in_a_space_of_curvature(k, correction):
    rng = np.random.default_rng(1)
    vertices, corrections = 0.3 * rng.normal(size=(5, 3)), correction * rng.normal(size=(5, 3))
    edges = np.array([(a, b) for a in range(5) for b in range(a)])
    x = from_model(Space(k), vertices, "conformal")
    lengths = Space(k).distances(x[edges[:, 0]], x[edges[:, 1]])
    divisors = Space(k).sn(lengths)
    values, errors = enclosed_residuals(
        edges, vertices, corrections, lengths, squared_chords(lengths, k), divisors
    )
    points = [[Fraction(v) + Fraction(c) for v, c in zip(*rows, strict=True)]
              for rows in zip(vertices, corrections, strict=True)]  # fmt: skip
    m = [1 + Fraction(k) / 4 * sum(c * c for c in p) for p in points]
    for i, (a, b) in enumerate(edges):
        square = sum((p - q) ** 2 for p, q in zip(points[a], points[b], strict=True))
        truth = (square - exact_squared_chord(lengths[i], k) * m[a] * m[b]) / (2 * Fraction(divisors[i]))
        assert abs(Fraction(values[i]) - truth) <= Fraction(errors[i])
    assert errors.max() < 1e-26 + 5e-14 * np.abs(values).max()
