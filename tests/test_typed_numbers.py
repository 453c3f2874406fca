"""Numbers and lengths as people type them."""

import pytest

from isoembed.typed_numbers import millimeters, number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("1,5", 1.5),
        ("-0,125", -0.125),
        ("1e-3", 1e-3),
        (" 2 ", 2.0),
        ("1,2345", 1.2345),
        ("1.000,5", 1000.5),
        ("1,345,678.25", 1345678.25),
        ("1 345,8", 1345.8),
        ("6.7D+01", 67.0),
    ],
)
def test_numbers(text, value):
    assert number(text) == value


@pytest.mark.parametrize("text", ["1,500", "-12,000", "1,2,3", "1,000,5", "1.00,5", "", "one", "1 mm"])
def test_what_is_no_number_or_two(text):
    """A comma before three digits may be that of thousands."""
    with pytest.raises(ValueError, match="could not convert string to float"):
        number(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [("15", 15.0), ("15mm", 15.0), ("1,5 cm", 15.0), ("0.2m", 200.0), ("2in", 50.8), ('2"', 50.8)],
)
def test_lengths_on_paper(text, value):
    assert millimeters(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["2ft", "2dm", "2km", "2µm", "2 min", "mm", "1,500mm", "2 3mm"])
def test_what_is_no_length(text):
    with pytest.raises(ValueError, match="could not convert string to float"):
        millimeters(text)
