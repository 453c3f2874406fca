"""Continuation: predictors of a path, and penalties whose weight vanishes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.nonlinear.continuation import extrapolated, penalty_continuation

A, B, C = np.random.default_rng(0).normal(size=(3, 5, 3))


def quadratic(t):
    return A + B * t + C * t**2


THREE_TIMES = st.lists(st.integers(0, 10), min_size=3, max_size=3, unique=True)


@given(THREE_TIMES.map(lambda times: [t / 10 for t in times]), st.floats(-0.5, 1))
def test_three_points_determine_a_quadratic(times, t):
    assert extrapolated([(s, quadratic(s)) for s in times], t) == pytest.approx(quadratic(t), abs=1e-11)


def test_two_points_determine_a_line_and_one_itself():
    line = extrapolated([(0.0, A), (1.0, A + B)], 3.0)
    assert line == pytest.approx(A + 3 * B, abs=1e-14)
    assert (extrapolated([(0.3, A)], 0.7) == A).all()


GOAL, PREFERRED = np.array([1.0]), np.array([3.0])


def followed(goal=GOAL, **options):
    """Minima of |x - goal|^2 + mu |x - preferred|^2, and the weights."""
    weights = []

    def minimized(x, mu):
        weights.append(mu)
        return (goal + mu * PREFERRED) / (1 + mu)

    given = {"factor": 0.1, "max_weights": 30, "tolerance": 1e-6, "exhausted": lambda: False}
    x, residual = penalty_continuation(
        PREFERRED, minimized, lambda x: float(np.abs(x - GOAL).max()), 1.0, **given | options
    )
    return x, residual, weights


def test_the_error_falls_in_proportion_to_the_weight():
    x, residual, weights = followed()
    assert weights == pytest.approx(10.0 ** -np.arange(8))
    assert residual == abs(x - GOAL) == pytest.approx(2e-7, rel=1e-6)


def test_it_ends_where_the_residual_hardly_falls_twice():
    _, residual, weights = followed(goal=np.array([1.1]))  # what is to vanish does not
    assert residual == pytest.approx(0.1, rel=0.01)
    steps = [0.1 + 1.9 * mu / (1 + mu) for mu in weights]
    slow = [after > 0.9 * before for before, after in pairwise(steps)]
    assert slow == [False] * (len(slow) - 2) + [True, True]


def test_it_ends_when_the_weights_are_used_up_or_no_more_may_be_spent():
    assert len(followed(max_weights=3)[2]) == 3
    assert len(followed(exhausted=lambda: True)[2]) == 1
