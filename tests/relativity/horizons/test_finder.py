"""Horizons that are found: masses and stability of closed forms, a table of pairs of holes."""

from functools import cache

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NoHorizon
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons import finder, foliated_horizon
from isoembed.relativity.horizons.finder import constant_expansion, find_horizon, find_horizons
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.spacetimes.kerr_slices import BoyerLindquist, KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import (
    BoostedSchwarzschild,
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.transformed import Translated


def pair(d, masses=(0.5, 0.5), *, tilt=0.0, center=(0.0, 0.0, 0.0)):
    """Two holes at a distance, on an axis that is tilted from z towards x."""
    half = 0.5 * d * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    return BrillLindquist(masses, (half + center, -half + center))


@cache
def common(d, masses=(0.5, 0.5)):
    """The common horizon of an upright pair about the origin."""
    return find_horizon(pair(d, masses))


def largest_expansion(horizon):
    """At points of its own: a second computation, by harmonics that are summed one by one."""
    u, _ = gauss_rule(17, 35)
    return np.abs(horizon.surface.expansion(horizon.geometry, u)).max()


@pytest.mark.parametrize(
    "geometry",
    [IsotropicSchwarzschild(2.0), PainleveGullstrand(2.0), KerrSchild(2.0, (0.0, 0.0, 0.0))],
    ids=lambda geometry: type(geometry).__name__,
)
def test_schwarzschild(geometry):
    horizon = find_horizon(geometry)
    assert horizon.irreducible_mass == pytest.approx(2.0, rel=1e-14)
    # L = -Laplacian + 1 / R^2 where the slice is time-symmetric; d theta / dn = 1 / 4 M^2 in all three.
    assert horizon.stability == pytest.approx(1.0, abs=1e-9)
    assert horizon.outer
    assert largest_expansion(horizon) < 1e-13


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.9), (0.3, -0.4, 0.5)])
def test_kerr_up_and_tilted(spin):
    geometry = KerrSchild(1.0, spin)
    horizon = find_horizon(geometry)
    exact = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    u, _ = gauss_rule(9, 19)
    assert np.abs(horizon.surface.points(u) - exact.points(u)).max() < 1e-12
    assert horizon.irreducible_mass == pytest.approx(np.sqrt(0.5 * geometry.horizon), rel=1e-13)
    assert 0.0 < horizon.stability < 1.0


def test_a_hole_in_motion_has_the_area_of_one_at_rest():
    horizon = find_horizon(BoostedSchwarzschild(1.0, (0.2, 0.3, 0.1), (1.0, 2.0, 3.0)))
    assert horizon.area == pytest.approx(16.0 * np.pi, rel=1e-12)
    assert horizon.residual < 1e-12


@pytest.mark.parametrize(
    ("d", "masses", "mass"),
    [
        (0.5, (0.5, 0.5), 0.998248418),
        pytest.param(0.6, (0.5, 0.5), 0.996294662, marks=pytest.mark.slow),
        pytest.param(0.7, (0.5, 0.5), 0.992722898, marks=pytest.mark.slow),
        (0.765, (0.5, 0.5), 0.988481603),
        (0.5, (0.2, 0.8), 0.999007214),
    ],
)
def test_common_horizons_of_two_holes(d, masses, mass):
    horizon = common(d, masses)
    assert horizon.irreducible_mass == pytest.approx(mass, abs=6e-10)
    assert horizon.outer
    assert horizon.residual < 1e-12
    assert horizon.surface.harmonics.order == 0


def test_the_same_off_the_axis():
    upright, tilted = common(0.5), find_horizon(pair(0.5, tilt=0.7, center=(0.1, 0.2, 0.3)))
    assert tilted.area == pytest.approx(upright.area, rel=1e-13)
    assert tilted.stability == pytest.approx(upright.stability, abs=1e-10)


def test_two_separate_horizons():
    horizons = find_horizons(pair(1.0))
    assert [horizon.irreducible_mass for horizon in horizons] == pytest.approx([0.624999260] * 2, abs=6e-10)
    largest = find_horizon(pair(1.0, (0.4, 0.6)))
    assert "of 2 separate horizons; the others have" in largest.notes[0]
    for horizon in find_horizons(pair(1.0, (0.4, 0.6))):
        assert "around ({:.6g}, {:.6g}, {:.6g})".format(*horizon.surface.center) in largest.notes[0]
    assert largest.outermost.kind == "searched"
    assert "reach a least c R / 2 above zero" in largest.outermost.basis


def test_units_do_not_matter():
    horizons = [find_horizon(pair(0.5 * L, (0.5 * L, 0.5 * L))) for L in (1e-3, 1e6)]
    masses = [h.irreducible_mass / L for h, L in zip(horizons, (1e-3, 1e6), strict=True)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-13)
    assert horizons[0].stability == pytest.approx(horizons[1].stability, rel=1e-9)


def test_surfaces_of_constant_expansion():
    # theta = 2 / r (1 - sqrt(2 M / r))
    sphere = constant_expansion(PainleveGullstrand(1.0), 0.05, StarSurface.sphere((0.0, 0.0, 0.1), 2.2))
    u, _ = gauss_rule(9, 19)
    r = float(np.linalg.norm(sphere.surface.points(u), axis=1).mean())
    assert 2.0 / r * (1.0 - np.sqrt(2.0 / r)) == pytest.approx(0.05, abs=1e-12)
    assert np.abs(np.linalg.norm(sphere.surface.points(u), axis=1) - r).max() < 1e-11


@pytest.mark.parametrize(
    ("mass", "d", "area"),
    [
        (0.2, 0.65, 49.8984892225),  # the tutorial of MOTSFinder
        (0.5, 0.75, 49.239871799),
        pytest.param(0.1, 0.595, 50.130701201, marks=pytest.mark.slow),
        pytest.param(0.4, 0.754, 49.221090647, marks=pytest.mark.slow),
    ],
)
def test_common_horizons_near_their_end(mass, d, area):
    horizon = common(d, (mass, 1.0 - mass))
    assert horizon.area == pytest.approx(area, abs=2e-9)
    assert horizon.outer and not horizon.notes
    assert horizon.outermost.kind == "searched"
    assert "the expansion is positive on" in horizon.outermost.basis


@pytest.mark.slow
def test_a_common_horizon_of_three_holes():
    # 49.98358 by minimizing the area in harmonics of degree 20
    at = ((0.091, -0.228, -0.052), (-0.166, 0.13, -0.373), (0.007, 0.147, 0.264))
    horizon = find_horizon(BrillLindquist((0.3814, 0.2252, 0.3934), at))
    assert horizon.area == pytest.approx(49.983577547, abs=1e-8)
    assert horizon.outermost.kind == "searched"
    assert "the expansion is positive on" in horizon.outermost.basis


@pytest.mark.slow
def test_a_light_hole_on_a_heavy_one():
    horizon = find_horizon(pair(0.5, (0.01, 0.99)))
    assert horizon.area == pytest.approx(50.2637718616, abs=1e-8)
    assert horizon.residual < 1e-11


def test_a_tilted_pair_is_a_surface_of_revolution():
    # Degree 192: the map of its own axis
    upright, tilted = common(0.65, (0.2, 0.8)), find_horizon(pair(0.65, (0.2, 0.8), tilt=0.7))
    assert tilted.area == pytest.approx(upright.area, rel=1e-11)
    assert tilted.surface.harmonics.order == 1
    assert largest_expansion(tilted) < 1e-8


@pytest.mark.parametrize(
    "velocity", [(0.0, 0.0, 0.95), pytest.param((0.57, 0.0, 0.76), marks=pytest.mark.slow)]
)
def test_a_fast_hole_has_the_area_of_one_at_rest(velocity):
    horizon = find_horizon(BoostedSchwarzschild(1.0, velocity, (1.0, 2.0, 3.0)))
    assert horizon.area == pytest.approx(16.0 * np.pi, rel=1e-12)
    assert horizon.stability == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("spin", [(0.0, 0.0, 1.0), pytest.param((0.0, 0.6, 0.8), marks=pytest.mark.slow)])
def test_extreme_kerr_is_degenerate(spin):
    horizon = find_horizon(KerrSchild(1.0, spin))
    assert horizon.area == pytest.approx(8.0 * np.pi, rel=1e-10)
    assert horizon.notes[-1].startswith("degenerate: its stability eigenvalue is")


@pytest.mark.slow
def test_nearly_extreme_kerr_is_not():
    geometry = KerrSchild(1.0, (0.0, 0.0, 1.0 - 1e-8))
    horizon = find_horizon(geometry)
    assert horizon.area == pytest.approx(8.0 * np.pi * geometry.horizon, rel=1e-10)
    assert horizon.stability > 1e-5 and not horizon.notes


def test_a_horizon_that_exists_and_is_not_resolved(monkeypatch):
    def fails(*_, **__):
        raise NoConvergence("Newton's method stalls")

    monkeypatch.setattr(foliated_horizon, "horizon_near", fails)
    with pytest.raises(
        NoHorizon, match="a horizon exists between two surfaces, but was not resolved"
    ) as failure:
        find_horizons(pair(0.7))
    assert failure.value.evidence.kind == "proved"
    u, _ = gauss_rule(20, 41)
    outer, inner = (surface.expansion(pair(0.7), u) for surface in failure.value.barriers)
    assert inner.max() < 0.0 < outer.min()


def test_a_larger_horizon_that_is_not_excluded(monkeypatch):
    # Of the pair no leaf is known, as if the slice ended: it is not said that the horizons are separate.
    def blocked(geometry, start):
        if start.mean_radius > 1.0:
            raise NoHorizon("no horizon was found: the slice ends there")
        return foliated(geometry, start)

    foliated = finder.foliated_horizon
    monkeypatch.setattr(finder, "foliated_horizon", blocked)
    horizon = find_horizon(pair(0.7))
    assert horizon.outermost.kind == "searched"
    assert "it is not known whether a larger horizon encloses this one" in horizon.notes[0]
    assert "of 2 horizons that were found" in horizon.notes[1]


@pytest.mark.parametrize("radius", [0.35, 0.15])
def test_nothing_is_said_of_larger_horizons_around_one_near_a_guess(radius):
    horizon = find_horizon(pair(0.5), StarSurface.sphere((0.0, 0.0, 0.25), radius))
    assert horizon.irreducible_mass == pytest.approx(0.749986858, abs=6e-10)
    assert horizon.outer and horizon.outermost is None


def test_from_a_trapped_sphere_outward():
    horizon = find_horizon(IsotropicSchwarzschild(1.0), StarSurface.sphere((0.0, 0.0, 0.0), 0.01))
    assert horizon.area == pytest.approx(16.0 * np.pi, rel=1e-12)


def test_a_guess_without_the_symmetry_of_the_slice():
    guess = StarSurface.from_radius(lambda u: 9.0 + 1.5 * u[:, 0] * u[:, 1])
    assert find_horizon(IsotropicSchwarzschild(0.1), guess).irreducible_mass == pytest.approx(0.1, rel=1e-12)


def test_separate_is_not_said_where_not_all_groups_were_tried():
    # The pair is close, the third hole so far that its common horizons with one of them are not looked for.
    three = BrillLindquist((0.3, 0.3, 0.4), ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 30.0)))
    assert "of 3 horizons that were found" in find_horizon(three).notes[-1]


def test_a_common_horizon_found_from_one_hole_is_that_of_both(monkeypatch):
    """It is returned once, without the horizons inside of it, though the search around both ended."""
    of_both = common(0.5)

    def from_one(geometry, place):
        if len(place.holes) > 1:
            raise NoHorizon("the sign of the least expansion is not known")
        return of_both if 0 in place.holes else within(geometry, place)

    within = finder._inside_sphere
    monkeypatch.setattr(finder, "_inside_sphere", from_one)
    assert find_horizons(pair(0.5)) == (of_both,)


def test_a_common_horizon_found_last_takes_the_place_of_those_inside(monkeypatch):
    of_both = common(0.5)

    def from_the_second(geometry, place):
        if len(place.holes) > 1:
            raise NoHorizon("the sign of the least expansion is not known")
        return of_both if 1 in place.holes else within(geometry, place)

    within = finder._inside_sphere
    monkeypatch.setattr(finder, "_inside_sphere", from_the_second)
    assert find_horizons(pair(0.5)) == (of_both,)


def test_holes_without_a_horizon_are_named(monkeypatch):
    def alone(geometry, place):
        if 1 in place.holes:
            raise NoHorizon("no horizon was found", least=0.5, least_error=0.01)
        return inside(geometry, place)

    inside = finder._inside_sphere
    monkeypatch.setattr(finder, "_inside_sphere", alone)
    (horizon,) = find_horizons(pair(1.0))
    assert "no horizon was found around the black holes 1," in horizon.notes[0]


@pytest.mark.parametrize(
    ("geometry", "sentence"),
    [
        (KerrSchild(1.0, (0.0, 0.0, 1.5)), "there is no horizon: the spin 1.5 exceeds the mass 1"),
        (BoyerLindquist(1.0, (0.0, 0.0, 0.5)), "singular on the horizon: take KerrSchild"),
    ],
)
def test_slices_that_have_no_horizon_say_so(geometry, sentence):
    for guess in (None, StarSurface.sphere((1.0, 0.0, 0.0), 3.0)):
        with pytest.raises(InvalidParameter, match=sentence):
            find_horizon(Translated(geometry, (1.0, 0.0, 0.0)), guess)
