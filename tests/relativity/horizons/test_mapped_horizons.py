"""Horizons of any shape: inner common ones, those of Kerr, guesses that are mapped surfaces."""

import numpy as np
import pytest

from isoembed.errors import NoHorizon
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.finder import constant_expansion, find_horizon, inner_horizon
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.schwarzschild import (
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface


def pair(d):
    return BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.5 * d), (0.0, 0.0, -0.5 * d)))


def largest_expansion(horizon):
    u, _ = gauss_rule(41, 3)
    return np.abs(horizon.surface.expansion(horizon.geometry, u)).max()


def test_the_inner_common_horizon():
    outer = find_horizon(pair(0.7))
    inner = inner_horizon(outer)
    assert inner.stability < 0.0
    assert not inner.outer
    assert inner.area > outer.area
    assert largest_expansion(inner) < 1e-10
    # That r(u) of degree 192 leads to.
    assert inner.irreducible_mass == pytest.approx(1.0005333167341, rel=1e-12)
    assert inner.stability == pytest.approx(-1.741944063271, abs=1e-9)


@pytest.mark.slow
def test_an_inner_one_with_a_thin_waist():
    inner = inner_horizon(find_horizon(pair(0.5)))
    assert inner.irreducible_mass == pytest.approx(1.081780729, abs=6e-10)
    assert largest_expansion(inner) < 1e-9


def test_both_are_one_where_they_end():
    outer = find_horizon(pair(0.766197))
    inner = inner_horizon(outer)
    assert inner.area == pytest.approx(outer.area, rel=1e-5)
    assert inner.stability == pytest.approx(-outer.stability, rel=0.02)


@pytest.mark.slow
def test_the_inner_horizon_of_kerr():
    geometry = KerrSchild(1.0, (0.0, 0.0, 0.8))
    inner = inner_horizon(find_horizon(geometry))
    r = 1.0 - 0.6
    assert inner.irreducible_mass == pytest.approx((0.5 * r) ** 0.5, rel=1e-12)
    assert not inner.outer


def test_a_hole_without_an_inner_horizon():
    with pytest.raises(NoHorizon, match="no inner horizon was found in the searched region"):
        inner_horizon(find_horizon(IsotropicSchwarzschild(1.0)))


def test_guesses_that_are_mapped():
    geometry = KerrSchild(1.0, (0.1, 0.2, 0.2))
    M = np.diag([1.7, 1.8, 1.6]) + 0.1
    horizon = find_horizon(geometry, MappedSurface.from_map(lambda u: u @ M.T))
    assert isinstance(horizon.surface, MappedSurface)
    assert horizon.irreducible_mass == pytest.approx(np.sqrt(0.5 * geometry.horizon), rel=1e-12)
    assert largest_expansion(horizon) < 1e-9


def test_constant_expansion_from_a_mapped_guess():
    star = StarSurface.sphere((0.0, 0.0, 0.0), 2.2)
    mapped = MappedSurface.from_map(lambda u: 2.1 * u + 0.05)
    found = [constant_expansion(PainleveGullstrand(1.0), 0.05, guess).area for guess in (star, mapped)]
    assert found[1] == pytest.approx(found[0], rel=1e-11)


def test_even_coordinates_leave_the_surface():
    # r = 2 + cos^2(theta): lengths of the meridian between nodes are those of the whole.
    star = StarSurface.from_angles(lambda theta, phi: 2.0 + np.cos(theta) ** 2)
    even = HarmonicMap.projected(star, 40, symmetric=True).reparametrized()
    x = even.jet_at_nodes(60).x
    r, z = np.linalg.norm(x, axis=1), x[:, 2]
    assert np.abs(r - 2.0 - (z / r) ** 2).max() < 1e-9
    u, _ = gauss_rule(60, 1)
    theta = np.arccos(u[:, 2])
    speed = np.linalg.norm(np.diff(x, axis=0), axis=1) / np.abs(np.diff(theta))
    assert np.ptp(speed) < 2e-3 * speed.mean()
