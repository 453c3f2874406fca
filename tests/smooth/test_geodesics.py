"""Geodesic lengths and curvature of smooth metrics: closed forms, rates, invariances, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gallery import Ellipsoid, Ergosphere, KerrHorizon
from isoembed.meshing.sphere import gauss_rule
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.geodesics import geodesic_lengths
from isoembed.smooth.two_metric import PulledBack, area_density
from smooth_metrics import ROUND, Dented, ellipsoid, kerr_surface, warp, warp_differential


def pairs(n, angle, seed=0):
    rng = np.random.default_rng(seed)
    P, t = rng.normal(size=(2, n, 3))
    P /= np.linalg.norm(P, axis=1, keepdims=True)
    t -= np.einsum("ni,ni->n", P, t)[:, None] * P
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    return P, P * np.cos(angle) + t * np.sin(angle)


def direction(theta, phi):
    return np.array([[np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]])


def worst_error(angle):
    P, Q = pairs(500, angle)
    x, y = warp(P), warp(Q)
    exact = 2 * np.arctan2(np.linalg.norm(x - y, axis=1), np.linalg.norm(x + y, axis=1))
    return np.abs(geodesic_lengths(ROUND, P, Q) / exact - 1).max()


def test_lengths_are_those_of_the_round_sphere_in_other_coordinates():
    assert worst_error(0.8) < 3e-5
    assert worst_error(0.4) < 3e-7
    assert worst_error(0.2) < 5e-9


def test_lengths_converge_with_the_sixth_order():
    coarse, fine = worst_error(0.12), worst_error(0.06)
    assert 5.5 < np.log2(coarse / fine) < 6.5
    assert coarse < 3e-10


@pytest.mark.parametrize(("length", "bound"), [(0.8, 1e-8), (0.4, 1e-9), (0.2, 2e-11), (0.1, 1e-12)])
def test_lengths_are_those_of_geodesics_on_a_horizon(length, bound):
    a2, r = 0.64, 1 + np.sqrt(1 - 0.64)

    def geodesic(_, state):
        theta, _, v, w = state
        s, Sigma = np.sin(theta), r * r + a2 * np.cos(theta) ** 2
        k, turn = (r * r + a2) ** 2, -a2 * np.sin(2 * theta)
        P, change = k * s**2 / Sigma, k * np.sin(2 * theta) / Sigma - k * s**2 * turn / Sigma**2
        return [v, w, (-0.5 * turn * v**2 + 0.5 * change * w**2) / Sigma, -change * v * w / P]

    for theta in (0.5, 1.0, 1.5):
        for angle in (0.3, 1.0, 1.4):
            Sigma = r * r + a2 * np.cos(theta) ** 2
            speeds = (
                np.cos(angle) / np.sqrt(Sigma),
                np.sin(angle) * np.sqrt(Sigma) / (r * r + a2) / np.sin(theta),
            )
            end = solve_ivp(
                geodesic, (0, length), [theta, 0.2, *speeds], method="DOP853", rtol=1e-13, atol=1e-15
            ).y[:2, -1]
            found = geodesic_lengths(kerr_surface(0.8), direction(theta, 0.2), direction(*end))
            assert abs(found[0] / length - 1) < bound


def test_lengths_do_not_depend_on_the_order_of_the_ends():
    for angle in (0.05, 0.5):
        P, Q = pairs(200, angle)
        for metric in (ROUND, ellipsoid(3, 2, 1), kerr_surface(0.975, 0.1)):
            there, back = geodesic_lengths(metric, P, Q), geodesic_lengths(metric, Q, P)
            assert np.abs(there / back - 1).max() < 1e-13


@settings(max_examples=20, deadline=None)
@given(st.integers(-450, 450), st.integers(0, 10**6))
def test_lengths_scale_exactly(exponent, seed):
    P, Q = pairs(20, 0.2, seed)
    scale = 2.0**exponent
    large = geodesic_lengths(PulledBack(lambda u: scale * warp_differential(u)), P, Q)
    assert np.array_equal(large, scale * geodesic_lengths(ROUND, P, Q))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_lengths_turn_with_the_sphere(seed):
    R = Rotation.random(random_state=seed).as_matrix()
    A = np.diag([3.0, 2.0, 1.0])
    turned = PulledBack(lambda u: np.broadcast_to(A @ R, (len(u), 3, 3)))
    P, Q = pairs(20, 0.2, seed)
    there = geodesic_lengths(ellipsoid(3, 2, 1), P @ R.T, Q @ R.T)
    assert np.abs(geodesic_lengths(turned, P, Q) / there - 1).max() < 1e-12


def test_a_path_goes_around_a_sharp_tip():
    metric, theta = kerr_surface(0.975, 0.1), np.radians(15.0)
    P, Q = direction(theta, 0.0), direction(theta, np.pi)
    length = geodesic_lengths(metric, P, Q)[0]

    def by_way_of(angle):
        middle = direction(angle, 0.5 * np.pi)
        return float(geodesic_lengths(metric, P, middle)[0] + geodesic_lengths(metric, middle, Q)[0])

    around = minimize_scalar(by_way_of, bounds=(0.02, 0.5), method="bounded", options={"xatol": 1e-5}).fun
    over = 2 * geodesic_lengths(metric, P, direction(0.0, 0.0))[0]
    assert around < 0.9 * over
    assert abs(length / around - 1) < 1e-3


def test_equal_ends_are_at_no_distance():
    P, _ = pairs(3, 0.1)
    assert np.array_equal(geodesic_lengths(ROUND, P, P), np.zeros(3))


def test_no_paths_have_no_lengths():
    assert geodesic_lengths(ROUND, np.empty((0, 3)), np.empty((0, 3))).shape == (0,)


def test_ends_on_opposite_sides_are_refused():
    P, Q = pairs(3, 0.1)
    Q[1] = -P[1]
    with pytest.raises(InvalidParameter, match=r"the ends of path 1 are 180 degrees apart, but at most 170"):
        geodesic_lengths(ROUND, P, Q)


def test_a_metric_that_is_not_positive_is_refused_with_the_place_and_the_value():
    P, Q = direction(0.2, 1.0), direction(0.3, 1.0)
    with pytest.raises(InvalidMetric, match=r"has the eigenvalue -0\.5 at theta = 0\.2, phi = 1: it must be"):
        geodesic_lengths(Dented(-1.5), P, Q)
    with pytest.raises(InvalidMetric, match=r"the metric is not finite at theta = 0\.2, phi = 1: it must"):
        geodesic_lengths(Dented(np.nan), P, Q)
    with pytest.raises(InvalidMetric, match=r"has the eigenvalue -0\.5 at theta = 0\.2, phi = 1"):
        gaussian_curvature(Dented(-1.5), P)


@pytest.mark.parametrize(
    ("metric", "surface", "bound"),
    [
        (ellipsoid(3, 2, 1), Ellipsoid((3, 2, 1)), 2e-8),
        (kerr_surface(0.8), KerrHorizon(1, 0.8), 1e-7),
        (kerr_surface(0.975, 1.5), Ergosphere(1.5), 1e-6),
    ],
)
def test_curvature_is_that_of_the_closed_form(metric, surface, bound):
    u, _ = pairs(300, 0.1)
    u = np.concatenate([u, np.eye(3), -np.eye(3), direction(2e-3, 1.0), direction(5e-4, 2.0)])
    K = surface.gaussian_curvature(u)
    assert np.abs(gaussian_curvature(metric, u) - K).max() < bound * np.abs(K).max()


def test_curvature_of_the_round_sphere_in_other_coordinates_is_1():
    u, _ = pairs(300, 0.1)
    assert np.abs(gaussian_curvature(ROUND, u) - 1).max() < 3e-8


def test_total_curvature_is_4_pi_where_no_surface_is_known():
    u, weight = gauss_rule(40, 80)
    metric = kerr_surface(0.95)
    K = gaussian_curvature(metric, u)
    assert K.min() < -0.01
    total = weight @ (K * area_density(metric.tensor(u)))
    assert abs(total / (4 * np.pi) - 1) < 1e-8


@settings(max_examples=10, deadline=None)
@given(st.integers(-400, 400))
def test_curvature_scales_exactly(exponent):
    u, _ = pairs(20, 0.1)
    scale = 2.0**exponent
    K = gaussian_curvature(PulledBack(lambda u: scale * warp_differential(u)), u)
    assert np.array_equal(K * scale * scale, gaussian_curvature(ROUND, u))
