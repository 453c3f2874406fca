"""Foliations by surfaces of constant expansion, through the minimum where common horizons end."""

from itertools import pairwise

import pytest

from isoembed.relativity.horizons.constant_expansion import constant_expansion_surface
from isoembed.relativity.horizons.finder import find_horizon, find_horizons
from isoembed.relativity.horizons.foliation import foliate, inside, least_expansion
from isoembed.relativity.spacetimes.schwarzschild import BrillLindquist
from isoembed.relativity.spacetimes.star_surface import StarSurface


def pair(d):
    return BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.5 * d), (0.0, 0.0, -0.5 * d)))


def least(d, near):
    """The leaf of least expansion near a horizon of a slice nearby."""
    outer, inner = (
        constant_expansion_surface(pair(d), leaf)
        for leaf in (StarSurface(near.center, near.harmonics, s * near.coefficients) for s in (1.2, 0.9))
    )
    return least_expansion(pair(d), outer, inner, settled=1e-6)


@pytest.mark.slow
def test_common_horizons_end_where_the_least_expansion_is_zero():
    a, b = 0.765, 0.7663
    near = find_horizon(pair(a)).surface
    (at_a, _), (at_b, _) = least(a, near), least(b, near)
    assert at_a.expansion < 0.0 < at_b.expansion
    at_a, at_b = at_a.expansion, at_b.expansion
    for _ in range(3):
        a, b, at_a = b, b - at_b * (b - a) / (at_b - at_a), at_b
        leaf, error = least(b, near)
        at_b = leaf.expansion
    assert b == pytest.approx(0.766197428, abs=1e-9)
    assert error < 1e-6
    assert 0.5 * leaf.areal_radius == pytest.approx(0.98835875, abs=1e-8)
    assert leaf.rate == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_stability_falls_to_zero_with_a_square_root():
    end = 0.76619742824
    far, near = (find_horizon(pair(end - gap)).stability / gap**0.5 for gap in (4e-6, 1e-6))
    assert near == pytest.approx(far, rel=5e-3)


@pytest.mark.parametrize("gap", [1e-6, pytest.param(1e-9, marks=pytest.mark.slow)])
def test_beyond_the_end_there_are_two(gap):
    end = 0.76619742824
    assert len(find_horizons(pair(end - gap))) == 1
    assert len(find_horizons(pair(end + gap))) == 2


def test_leaves_are_barriers():
    foliation = foliate(pair(0.7), StarSurface.sphere((0.0, 0.0, 0.0), 3.0), symmetric=True)
    outer, inner = foliation.barriers
    assert inner.upper < 0.0 < outer.lower
    surfaces = [leaf.surface for leaf in foliation.leaves]
    assert all(inside(small, large) for large, small in pairwise(surfaces))
    assert not inside(surfaces[0], surfaces[1])


def test_no_step_passes_over_the_horizons():
    # The expansion is negative between two surfaces 1e-3 apart.
    foliation = foliate(pair(0.76619), StarSurface.sphere((0.0, 0.0, 0.0), 3.0), symmetric=True)
    assert foliation.barriers is not None
    assert -1e-4 < foliation.barriers[1].normalized_expansion < 0.0


@pytest.mark.slow
def test_the_error_of_a_minimum_of_the_normalized_expansion_alone():
    # Far apart the expansion itself has no minimum, only c R / 2; finer steps find it within the error.
    def minimum(step):
        start = StarSurface.sphere((0.0, 0.0, 0.0), 4.0)
        found = foliate(pair(4.0), start, symmetric=True, longest_step=step)
        assert found.excludes
        return found.minimum, 0.5 * found.minimum_error * found.minimum.areal_radius

    (coarse, error), (fine, _) = minimum(0.15), minimum(0.03)
    assert (
        coarse.normalized_expansion - error <= fine.normalized_expansion <= coarse.normalized_expansion + 1e-3
    )
