"""Energies in the least hyperbolic space of horizons that have errors."""

from dataclasses import replace

import numpy as np
import pytest

from isoembed.relativity import KerrNewmanHorizon, KerrSchild, StarSurface, chen_wang_yau, embed_surface
from isoembed.smooth import embed_smooth
from isoembed.space import EUCLIDEAN, Hyperbolic, Space

SPIN = 0.93 * np.array([0.48, 0.6, 0.64])
EXACT = 1.894566397859  # a quadrature in more digits
EXTREME = 2.0196563952021


@pytest.mark.parametrize(("count", "noise"), [pytest.param(600, 1e-4, marks=pytest.mark.slow), (1000, 1e-3)])
def test_points_with_noise(count, noise):
    hole, rng = KerrSchild(1.0, tuple(SPIN)), np.random.default_rng(1)
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    x = hole.spheroid(hole.horizon)(u)[:, None] * u
    x += noise * rng.normal(size=x.shape)
    surface = embed_surface(
        StarSurface.from_points(x, (0.0, 0.0, 0.0)).data(hole, marginal=True), space="hyperbolic"
    )
    energy = surface.energies.liu_yau
    assert abs(energy.value - EXACT) <= energy.error <= 300.0 * noise
    assert not surface.energies.notes
    told = surface.report["space"]["least"]
    assert abs(surface.space.curvature + 0.09684439994835) <= told["error"] == surface.curvature_error
    # Nearly all of it is what the curvature is uncertain by.
    assert energy.error == pytest.approx(
        3.0 * surface.embedding.volume * surface.curvature_error / (8.0 * np.pi), rel=0.1
    )


def test_the_extreme_hole_states_the_rounding_of_its_curvature():
    energy = embed_surface(KerrNewmanHorizon(1.0, 1.0).data(), space="hyperbolic").energies.liu_yau
    assert abs(energy.value - EXTREME) <= energy.error <= 1e-10


@pytest.mark.parametrize("space", [EUCLIDEAN, Hyperbolic(0.2)])
def test_the_derivative_of_the_integral_by_the_curvature(space):
    horizon, h = KerrNewmanHorizon(1.0, 0.6), 1e-4
    low, middle, high = (embed_smooth(horizon, space=Space(space.curvature + step)) for step in (-h, 0.0, h))
    slope = (high.integrated_mean_curvature - low.integrated_mean_curvature) / (2.0 * h)
    growth = (high.volume - low.volume) / (2.0 * h)
    assert slope == pytest.approx(-1.5 * middle.volume - space.curvature * growth, rel=1e-5)
    assert growth > 0.0


def test_an_uncertain_reference_makes_the_energy_of_observers_uncertain():
    data = KerrNewmanHorizon(1.0, 0.9).data()
    surface = embed_surface(data, space=Hyperbolic(0.3))
    sure, unsure = (chen_wang_yau(data, surface.embedding, curvature_error=e).energy for e in (0.0, 1e-3))
    other = embed_surface(data, space=Space(-0.3 + 1e-3))
    assert unsure.value == sure.value
    change = abs(chen_wang_yau(data, other.embedding).energy.value - sure.value)
    assert change <= unsure.error <= 5.0 * change


@pytest.mark.slow
def test_a_horizon_that_is_a_little_off_has_another_curvature():
    data = KerrNewmanHorizon(1.0, 0.9).data()
    off = embed_surface(replace(data, displacement=1e-6), space="hyperbolic")
    # K about 1 / R^2, R^2 = r^2 + a^2, changes by eight times the relative change of lengths.
    assert off.curvature_error == pytest.approx(8e-6 / (1.4358898943540674**2 + 0.81), rel=1e-3)
    assert off.energies.liu_yau.error > 1e-6
