"""Energies through a head-on merger of moving holes."""

import pytest

from reproduction import bowen_york
from sections import check_section

pytestmark = pytest.mark.slow


def test_masses_agree_with_those_that_are_known():
    for one in bowen_york._published():
        assert one.agrees, one.what
        assert abs(one.ours - one.second) <= 2 * one.error, one.what


def test_a_common_horizon_is_told_from_one_of_two():
    near, far = (bowen_york._energies(0.2, d) for d in (0.76, 0.8))  # it appears at 0.794
    assert (near["which"], far["which"]) == ("common", "one of two")
    assert far["liu_yau"] == pytest.approx(2 * far["mass"], rel=1e-3)
    assert near["mass"] < near["infinity"]


def test_the_section(monkeypatch):
    monkeypatch.setattr(bowen_york, "appearance", lambda P: 0.7661974282 + P / 10)  # tested by itself
    section = bowen_york.study(distances=(1.0, 0.7), expansions=(0.1, 1e-2, 1e-3), momenta=(0.5,))
    check_section(section)
    *_, far, near = section.numbers["constant_expansion"]
    assert far["wang_yau"] < near["wang_yau"] < near["limit"]
    assert near["wang_yau"] < near["liu_yau"]  # tau = 0 is not critical: K_ij is not zero
    below = [one["limit"] - one["wang_yau"] for one in (far, near)]
    assert below[0] / below[1] == pytest.approx(10**0.5, rel=0.05)
