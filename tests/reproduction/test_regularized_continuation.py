"""The guided pull-back: routines, paths and extrapolation."""

import numpy as np
import pytest

from reproduction import regularized_continuation
from reproduction.bodies import SAME
from sections import check_section

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def section():
    return regularized_continuation.study(cases=(("drum", 200, 5),), path_vertices=60)


def test_the_section_can_be_written(section):
    check_section(section)


def test_only_the_corrected_routine_leads_to_the_given_surface(section):
    (case,) = section.numbers["pull_backs"]
    ways = case["routines"]
    assert all(len(way["t"]) == 2 + case["steps"] for way in ways.values())
    assert ways["corrected"]["crumpled"][0] > ways["corrected"]["crumpled"][-1] == 0
    assert ways["corrected"]["concave"][-1] == case["concave_given"]
    assert ways["corrected"]["off"] < SAME
    for routine in ("printed", "none"):
        assert ways[routine]["crumpled"][-1] >= ways[routine]["crumpled"][0]
        assert ways[routine]["residual"] <= 1e-6  # the lengths do not tell
        assert ways[routine]["off"] > 100 * SAME


def test_extrapolation_helps_and_the_flows_path_does_not(section):
    for found in section.numbers["paths"].values():
        linear, *_, flow = found["paths"]
        assert len(linear["arrived"]) > len(flow["arrived"])
        assert linear["iterations"] < flow["iterations"]
        assert linear["longest"] < flow["longest"]
        assert found["extrapolation"]["factor"] > 10
        assert found["extrapolation"]["iterations"] < found["extrapolation"]["without"]
        guesses = np.array(found["extrapolation"]["guesses"])
        np.testing.assert_array_equal(guesses[:3, 0], guesses[:3, 1])  # j = 1, 2, 3 start from before


def test_deficits_change_evenly_on_the_linear_path(section):
    for found in section.numbers["paths"].values():
        assert found["rates"]["deficits"] == pytest.approx(1, abs=0.1)
        assert found["rates"]["curvature"] > 1.5
