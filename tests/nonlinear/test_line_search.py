"""Sufficient decrease: which fractions are tried, and which values are small enough."""

import numpy as np
import pytest

from isoembed.nonlinear.acceptance import FULL_STEPS, LineSearch, contraction
from isoembed.nonlinear.descent import Reason, descend
from isoembed.nonlinear.stopping import never


def test_fractions_are_halved_down_to_the_shortest():
    assert list(LineSearch(0.1, 0.25).parameters()) == [1.0, 0.5, 0.25]
    assert list(LineSearch(0.1, 0.1).parameters(0.3)) == [0.3, 0.15]
    assert list(LineSearch(0.1, 2.0).parameters()) == []
    assert list(FULL_STEPS.parameters()) == list(contraction(0.5).parameters()) == [1.0]


def test_the_decrease_that_is_asked_for_is_in_proportion_to_the_fraction():
    search = LineSearch(decrease=0.2, shortest=1e-3)
    for fraction in (1.0, 0.5, 0.25):
        most = 1 - 0.2 * fraction
        assert search.accepts(np.nextafter(most, 0), 1.0, fraction)
        assert not search.accepts(most, 1.0, fraction)


@pytest.mark.parametrize("rule", [LineSearch(0.0, 1e-3), contraction(1.0), FULL_STEPS])
def test_no_rule_accepts_what_is_no_number(rule):
    assert not rule.accepts(np.nan, 1.0, 1.0)
    assert not rule.accepts(np.inf, 1.0, 1.0)


def test_full_steps_may_go_uphill_and_others_may_not():
    assert FULL_STEPS.accepts(1e9, 1.0, 1.0)
    assert not LineSearch(0.0, 1.0).accepts(1.0, 1.0, 1.0)


def test_the_first_fraction_that_is_good_enough_is_taken():
    # |x| along x - 6 fraction from x = 1: 5, 2, 0.5.
    found = descend(
        1.0,
        lambda x: lambda fraction: x - 6.0 * fraction,
        LineSearch(0.1, 0.01),
        value=abs,
        converged=never,
        max_iterations=1,
    )
    assert (found.point, found.iterations, found.reason) == (-0.5, 1, Reason.EXHAUSTED)


def test_where_there_is_no_point_the_step_is_halved():
    found = descend(
        1.0,
        lambda x: lambda fraction: None if fraction > 0.3 else x - fraction,
        LineSearch(0.1, 0.01),
        value=abs,
        converged=never,
        max_iterations=1,
    )
    assert found.point == 0.75
