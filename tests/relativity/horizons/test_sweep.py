"""Surfaces of constant expansion through a fold: where common horizons end."""

import pytest

from isoembed.relativity.horizons.finder import find_horizon, find_horizons
from isoembed.relativity.horizons.sweep import leaf_of, least_expansion
from isoembed.relativity.spacetimes.conformally_flat import BrillLindquist


def pair(d):
    return BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.5 * d), (0.0, 0.0, -0.5 * d)))


def test_common_horizons_end_where_the_least_expansion_is_zero():
    a, b = 0.765, 0.7663
    leaf = leaf_of(pair(a), find_horizon(pair(a)).surface, symmetric=True)

    def least(d):
        nonlocal leaf
        leaf = least_expansion(pair(d), leaf, symmetric=True, settled=1e-6)
        return leaf.expansion

    at_a, at_b = least(a), least(b)
    assert at_a < 0.0 < at_b
    for _ in range(3):
        a, b, at_a = b, b - at_b * (b - a) / (at_b - at_a), at_b
        at_b = least(b)
    assert b == pytest.approx(0.766197428, abs=1e-9)
    assert 0.5 * leaf.areal_radius == pytest.approx(0.98835875, abs=1e-8)
    assert leaf.rate == pytest.approx(0.0, abs=1e-6)


def test_stability_falls_to_zero_with_a_square_root():
    end = 0.76619742824
    far, near = (find_horizon(pair(end - gap)).stability / gap**0.5 for gap in (4e-6, 1e-6))
    assert near == pytest.approx(far, rel=5e-3)


def test_beyond_the_end_there_are_two():
    assert len(find_horizons(pair(0.7661))) == 1
    assert len(find_horizons(pair(0.7663))) == 2
