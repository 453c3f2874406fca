"""Numbers with errors, as text: to the digit after the first that is uncertain."""

import math

import numpy as np
import pytest

from isoembed.surface.estimate import Estimate, percent


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (45.1207, 0.2, "45.12 +- 2e-01"),
        (1.8088402699295326, 5e-13, "1.8088402699295 +- 5e-13"),
        (-0.31504, 1e-2, "-0.315 +- 1e-02"),
        (1234567.0, 3.0, "1234567 +- 3e+00"),
        (3.9e-18, 5e-14, "4e-18 +- 5e-14"),
        (1.2345e-200, 1e-203, "1.2345e-200 +- 1e-203"),
        (0.0, 1e-9, "0 +- 1e-09"),
        (1.0 / 3.0, 0.0, "0.333333333333333 +- 0"),
        (1.7, 0.03, "1.70 +- 3e-02"),
        (1.25, 3e-13, "1.2500000000000 +- 3e-13"),
        (2.0, 5.0, "2 +- 5e+00"),
        (0.0, 0.0, "0 +- 0"),
        (float("nan"), 1.0, "nan +- 1e+00"),
    ],
)
def test_digits(value, error, text):
    assert str(Estimate(value, error)) == text


@pytest.mark.parametrize(
    ("fraction", "digits", "text"),
    [(1.1, 2, "110 %"), (0.1, 1, "10 %"), (7.93, 2, "790 %"), (0.0123, 2, "1.2 %"), (1e-9, 1, "1e-07 %")],
)
def test_percent(fraction, digits, text):
    assert percent(fraction, digits) == text


def test_an_infinite_error():
    assert str(Estimate(1.5, math.inf)) == "1.5 +- inf"


def test_an_estimate_is_a_number_by_float():
    found = Estimate(2.5, 0.1)
    assert float(found) / 5 == 0.5
    assert np.isclose(np.asarray([found, 1.0], dtype=float), [2.5, 1.0]).all()
