"""A number of a paper beside ours."""

import pytest

from reproduction.published import Published


@pytest.mark.parametrize(
    ("paper", "ours", "agrees", "digits"),
    [
        ("1.76569", 1.7656917209, True, "all 6"),
        ("1.76569", 1.7656950001, False, "not all"),
        ("2", 1.9999999999999987, True, "all 1"),
        ("0.62783144", 0.627831417, False, "not all"),
        ("", 1.5, False, ""),
    ],
)
def test_numbers_agree_if_ours_rounds_to_the_printed_one(paper, ours, agrees, digits):
    number = Published("a number", paper, ours, 1e-8, ours, "twice")
    assert number.agrees is agrees
    assert number.row["digits"] == digits
    assert number.row["paper"] == (paper or "not at hand")
    assert (number.numbers["agrees"] is None) == (not paper)


def test_ours_is_shown_to_its_error():
    assert Published("n", "1.8", 1.7656917209, 3e-5, 1.7657, "twice").shown == "1.76569"
    assert Published("n", "1.8", 1.7656917209, 0.0, 1.7657, "twice").shown == "1.765691720900"
