"""Costs of the stages."""

import pytest

from reproduction import scaling
from sections import check_section

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def section():
    return scaling.study(sizes=(60, 120), flow_sizes=(50, 100), step_sizes=(60, 400))


def test_the_section_can_be_written(section):
    check_section(section)


def test_costs_add_up_and_only_the_explicit_flow_takes_ever_more_evaluations(section):
    numbers = section.numbers
    for name, rows in numbers["timed"].items():
        for row in rows:
            for costs in row.values():
                parts = [costs[key] for key in costs if key not in (scaling.TOTAL, scaling.DEFAULT)]
                assert len(parts) == 5
                assert sum(parts) == pytest.approx(costs[scaling.TOTAL])
        assert abs(numbers["exponents"]["factorizations"][name][scaling.TOTAL]) < 0.5
        # An explicit integrator's steps shorten with the triangles.
        evaluations = numbers["flow_exponents"]["evaluations"][name]
        assert evaluations["RK45"] > evaluations["BDF"] + 0.3
    assert numbers["fewest_steps"]["drum"][1] >= numbers["fewest_steps"]["drum"][0] >= 1
