"""Thresholds as users are told them."""

import pytest

from isoembed.thresholds import rounded_down, rounded_up


@pytest.mark.parametrize("value", [1.0, 2.3e-7, 9.99e-5, 0.0401])
@pytest.mark.parametrize("digits", [1, 2])
def test_numbers_are_rounded_outward(value, digits):
    told = rounded_up(value, digits)
    assert value <= float(told) < (1 + 1.01 * 10 ** (1 - digits)) * value
    assert value >= float(rounded_down(value, digits)) > (1 - 1.01 * 10 ** (1 - digits)) * value
    assert len(told.split("e")[0].replace(".", "")) == digits
