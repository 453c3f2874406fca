"""The Gaussian curvature by harmonics of the metric, against closed forms."""

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrNewmanErgosphere, KerrNewmanHorizon, KerrSchild, StarSurface
from isoembed.smooth import AngleMetric, GridMetric
from isoembed.smooth.spectral_curvature import spectral_curvature

U = np.concatenate([fibonacci_directions(300), np.eye(3), -np.eye(3)])


@pytest.mark.parametrize("a", [0.0, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e6])
def test_kerr_horizons_to_rounding(a, unit):
    horizon = KerrNewmanHorizon(unit, a * unit)
    K = spectral_curvature(horizon)
    difference = np.abs(K(U) - horizon.gaussian_curvature(U)).max()
    assert difference <= K.error.pointwise <= 2e-11 / unit / unit
    assert difference <= 1e-12 / unit / unit


def test_a_tilted_horizon_has_no_symmetry_about_z():
    a = np.array([0.3, 0.5, 0.4])
    geometry = KerrSchild(1.0, a)
    surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    r2, along = geometry.horizon**2, (surface.points(U) @ a / geometry.horizon) ** 2
    expected = (r2 + a @ a) * (r2 - 3.0 * along) / (r2 + along) ** 3
    K = spectral_curvature(surface.metric(geometry))
    assert np.abs(K(U) - expected).max() <= min(K.error.pointwise, 1e-12)


def test_what_does_not_settle_says_so():
    sharp = KerrNewmanErgosphere(0.003)
    K = spectral_curvature(sharp)
    difference = np.abs(K(U) - sharp.gaussian_curvature(U)).max()
    assert 1e-9 < difference <= K.error.pointwise


def test_noise_of_lengths_is_in_the_error():
    theta, phi = (np.arange(24) + 0.5) * np.pi / 24, np.arange(48) * np.pi / 24
    sin = np.sin(theta)[:, None] * np.ones(48)
    noise = 1.0 + 2e-5 * np.random.default_rng(0).normal(size=sin.shape)
    grid = GridMetric(theta, phi, noise, 0.0 * sin, noise * sin**2)
    K = spectral_curvature(grid, 2e-5)
    assert 1e-5 < np.abs(K(U) - 1.0).max() <= K.error.pointwise <= 0.5


def test_total_curvature_of_an_uneven_metric():
    metric = AngleMetric(
        lambda theta, phi: (1.0 + 0.3 * np.cos(theta), 0.0, (1.0 + 0.3 * np.cos(theta)) * np.sin(theta) ** 2)
    )
    x = np.polynomial.legendre.leggauss(40)
    u = np.stack([np.sqrt(1.0 - x[0] ** 2), 0.0 * x[0], x[0]], axis=1)
    assert 0.5 * x[1] @ ((1.0 + 0.3 * x[0]) * spectral_curvature(metric)(u)) == pytest.approx(1.0, abs=1e-13)
