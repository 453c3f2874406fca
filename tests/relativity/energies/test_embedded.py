"""Surfaces of slices from their data to their energies: closed forms, uncertain data."""

from dataclasses import replace

import pytest

from isoembed.relativity import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    SurfaceData,
    embed_surface,
)
from isoembed.smooth import GridMetric

Z_AXIS = (0.0, 0.0, 1.0)
ENERGIES = ("irreducible_mass", "christodoulou_mass", "hawking", "brown_york", "liu_yau")
HORIZON = KerrNewmanHorizon(1.0, 0.5)


def within(estimate, exact, largest=1e-10):
    assert estimate.error <= largest
    assert abs(estimate.value - exact) <= estimate.error


@pytest.fixture(scope="module")
def horizon():
    return embed_surface(HORIZON.data(), vertices=100)


@pytest.fixture(scope="module")
def falling():
    """Schwarzschild, r = 6, in a flat slice."""
    return embed_surface(
        StarSurface.sphere((0.0, 0.0, 0.0), 6.0).data(PainleveGullstrand(1.0), Z_AXIS), vertices=60
    )


# energies


def test_a_horizon(horizon):
    found = horizon.energies
    within(found.area, 46.898333599528960)
    within(found.integrated_mean_curvature, 24.300446945608874)
    within(found.brown_york, 1.9337681253680011)
    within(found.liu_yau, 1.9337681253680011)
    within(found.hawking, 0.9659258262890682)
    within(found.christodoulou_mass, 1.0)


BROWN_YORK = {(0.5, 3.0): 1.2474088054291813, (0.5, 6.0): 1.0992882037637871, (0.8, 3.0): 1.2196541460073282}


@pytest.mark.parametrize(("a", "r"), BROWN_YORK)
def test_kerr_at_a_constant_radius(a, r):
    found = embed_surface(KerrNewmanSphere(r, 1.0, a).data(), vertices=60).energies
    within(found.brown_york, BROWN_YORK[a, r])
    assert found.liu_yau.value == pytest.approx(found.brown_york.value, abs=1e-13)  # p = 0


@pytest.mark.slow
def test_energies_of_the_mean_curvature_vector_do_not_depend_on_the_slice():
    """The surfaces r = const of both slices are the same surfaces of spacetime."""
    geometry = KerrSchild(1.0, (0.0, 0.0, 0.8))
    surface = StarSurface.from_radius(geometry.spheroid(3.0))
    found = embed_surface(surface.data(geometry, Z_AXIS), vertices=60).energies
    resting = embed_surface(KerrNewmanSphere(3.0, 1.0, 0.8).data(), vertices=60).energies
    within(found.liu_yau, BROWN_YORK[0.8, 3.0], 1e-10)
    for name in ("area", "integrated_mean_curvature", "hawking", "liu_yau"):
        ours, theirs = getattr(found, name), getattr(resting, name)
        assert abs(ours.value - theirs.value) <= ours.error + theirs.error
    assert found.brown_york.value < resting.brown_york.value - 0.1


def test_a_falling_slice(falling):
    within(falling.energies.brown_york, 0.0)
    within(falling.energies.liu_yau, 1.1010205144336438)
    within(falling.energies.hawking, 1.0)


@pytest.mark.slow
def test_an_ergosphere_whose_mean_curvature_changes_its_sign():
    found = embed_surface(KerrNewmanErgosphere(0.5).data(), vertices=200).energies
    within(found.integrated_mean_curvature, 33.021720529589184, 1e-9)
    within(found.area, 84.498458825124000)
    assert found.liu_yau is None and found.notes[0].startswith("k = -")


# uncertain data


def test_uncertain_lengths_loosen_what_is_asked_for(horizon):
    found = embed_surface(replace(HORIZON.data(), relative_error=1e-4), vertices=60)
    assert found.embedding.tolerance == pytest.approx(1e-2)
    assert found.embedding.harmonics.degree <= horizon.embedding.harmonics.degree
    for name in ("area", "integrated_mean_curvature", *ENERGIES):
        loose, exact = getattr(found.energies, name), getattr(horizon.energies, name)
        assert loose.error > 1e3 * exact.error
        assert abs(loose.value - exact.value) <= loose.error + exact.error


def test_data_that_are_wrong_within_their_error_are_embedded():
    """A grid that does not resolve the metric: the truth is within the errors."""
    coarse = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.8), 10, 4)
    assert 1e-6 < coarse.truncation < 1e-2
    found = embed_surface(SurfaceData(coarse, marginal=True), vertices=60)
    within(found.energies.area, 40.212385965949353, 1.0)
    within(found.energies.integrated_mean_curvature, 22.730557214111993, 1.0)


def test_a_grid_that_resolves_the_metric():
    grid = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.8), 48, 96)
    found = embed_surface(SurfaceData(grid, marginal=True), vertices=60)
    within(found.energies.area, 40.212385965949353, 1e-9)
    within(found.energies.liu_yau, 1.8088402699295326, 1e-9)
