"""The least Gaussian curvature of metrics with errors: without bias, and within what is stated."""

from functools import cache

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrNewmanHorizon, KerrSchild, StarSurface
from isoembed.smooth import GridMetric, least_hyperbolic
from isoembed.smooth.least_hyperbolic import LeastHyperbolic
from isoembed.smooth.spectral_curvature import spectral_curvature
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.uncertain_curvature import DeviatingMetric, UncertainCurvature
from isoembed.space import EUCLIDEAN, Space

SPIN = 0.93
LEAST = -0.09684439994835  # of K of the horizon, (r^2 - 3 a^2) / (r^2 + a^2)^2 at the poles
TILT = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])


@cache
def components(n):
    metric = metric_in(KerrNewmanHorizon(1.0, SPIN), SphereMap.linear(TILT))
    return GridMetric.sampled(metric, n, 2 * n)


def noisy(n, level, seed):
    exact, rng = components(n), np.random.default_rng(seed)
    q = (exact.q_tt, exact.q_tp, exact.q_pp)
    return GridMetric(exact.theta, exact.phi, *(c * (1.0 + level * rng.normal(size=c.shape)) for c in q))


@cache
def least_of(n, level, seed):
    return least_hyperbolic(noisy(n, level, seed))


@pytest.mark.parametrize("level", [1e-8, 1e-3])
def test_noise_on_a_grid(level):
    for seed in range(2):
        least = least_of(24, level, seed)
        off = abs(least.gaussian_curvature - LEAST)
        assert off <= least.error
        assert least.error <= 2e3 * level


def test_the_bias_of_the_least_value_is_removed():
    for seed in range(2):
        metric = noisy(24, 1e-3, seed)
        K = UncertainCurvature.of(metric)
        least = least_of(24, 1e-3, seed).gaussian_curvature
        raw = spectral_curvature(metric)(K.u).min()
        assert abs(least - LEAST) < 0.2 * (LEAST - raw)
        # The part of the bias that is left to deviations: min is concave.
        assert least > K.values.min()


def test_without_noise_nothing_is_cut_off():
    spin = SPIN * np.array([0.48, 0.6, 0.64])
    hole = KerrSchild(1.0, tuple(spin))
    metric = StarSurface.from_radius(hole.spheroid(hole.horizon)).data(hole).metric
    K, u = UncertainCurvature.of(metric), fibonacci_directions(200)
    assert isinstance(metric, DeviatingMetric)
    x = hole.spheroid(hole.horizon)(u)[:, None] * u
    along, r2 = (x @ spin / hole.horizon) ** 2, hole.horizon**2
    exact = (r2 + SPIN**2) * (r2 - 3.0 * along) / (r2 + along) ** 3
    np.testing.assert_allclose(K(u), exact, atol=1e-11)
    assert K.largest < 1e-10 and K.cut.max() < 1e-11
    least = least_hyperbolic(metric)
    assert abs(least.space.curvature - LEAST) <= least.error < 1e-9


@pytest.mark.parametrize("unit", [2.0**-300, 2.0**300])
def test_the_unit_of_length_does_not_matter(unit):
    grid = noisy(24, 1e-5, 0)
    q = (unit**2 * c for c in (grid.q_tt, grid.q_tp, grid.q_pp))
    one, other = least_of(24, 1e-5, 0), least_hyperbolic(GridMetric(grid.theta, grid.phi, *q))
    assert other.gaussian_curvature * unit**2 == pytest.approx(one.gaussian_curvature, rel=1e-6)
    assert other.error * unit**2 == pytest.approx(one.error, rel=1e-6)


def test_deviations_of_a_surface_are_those_of_its_points():
    flat = KerrSchild(1e-9, (0.0, 0.0, 0.0))
    rng = np.random.default_rng(0)
    u = rng.normal(size=(400, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    surface = StarSurface.from_points(u * (1.0 + 1e-3 * rng.normal(size=400))[:, None], (0.0, 0.0, 0.0))
    metric = surface.metric(flat)
    by_surface, by_slice = metric.deviations(fibonacci_directions(300))
    assert by_surface.shape == (12, 300, 3, 3) and not by_slice.any()
    # A sphere's lengths are off by what its radius is, and squares of lengths by twice as much.
    error = np.sqrt(np.mean((metric.tensor(fibonacci_directions(300)).trace(axis1=1, axis2=2) - 2.0) ** 2))
    told = np.sqrt(np.mean(by_surface.trace(axis1=2, axis2=3) ** 2))
    assert error / 3.0 < told < 10.0 * error


def test_euclidean_space_is_off_by_how_negative_the_curvature_may_be():
    assert LeastHyperbolic(EUCLIDEAN, 0.3, None, 0.1).curvature_error == 0.0
    assert LeastHyperbolic(EUCLIDEAN, 0.3, 0.05, 0.1).curvature_error == pytest.approx(0.05)
    least = LeastHyperbolic(Space(-0.25), -0.25, None, 0.01)
    assert least.curvature_error == 0.01
    assert least.explanation.startswith("the metric embeds in hyperbolic space of curvature -0.25")
