"""Real spherical harmonics and their derivatives, against their definition and each other."""

import numpy as np
import pytest
from scipy.special import sph_harm_y

from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.smooth.harmonics import Harmonics

POLES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])


def directions(n, seed=0):
    u = np.random.default_rng(seed).normal(size=(n, 3))
    return np.concatenate([u / np.linalg.norm(u, axis=1)[:, None], POLES])


def tangent_pair(u):
    t = np.cross(u, [0.36, 0.48, 0.8])
    t /= np.linalg.norm(t, axis=1)[:, None]
    return np.stack([t, np.cross(u, t)], axis=1)


def moved(u, t, h):
    return np.cos(h) * u + np.sin(h) * t


@pytest.mark.parametrize(("degree", "order"), [(0, 0), (9, 9), (40, 3)])
def test_they_are_orthonormal(degree, order):
    harmonics = Harmonics(degree, order)
    u, w = gauss_rule(degree + 1, 2 * order + 1)
    Y = harmonics.values(u)
    np.testing.assert_allclose(Y.T @ (w[:, None] * Y), np.eye(harmonics.size), atol=1e-12)


def test_they_are_those_of_scipy_up_to_sign():
    u = directions(20)[:-2]
    harmonics = Harmonics(12, 12)
    degrees, orders = harmonics.labels
    theta, phi = np.arccos(u[:, 2]), np.arctan2(u[:, 1], u[:, 0])
    for k, (l, m) in enumerate(zip(degrees, orders, strict=True)):
        Y = sph_harm_y(l, abs(m), theta, phi) * (-1.0) ** m * (np.sqrt(2.0) if m else 1.0)
        np.testing.assert_allclose(harmonics.values(u)[:, k], Y.real if m >= 0 else Y.imag, atol=1e-12)


def test_derivatives_are_those_along_great_circles():
    u = directions(12)
    t, h = tangent_pair(u), 1e-3
    harmonics = Harmonics(7, 7)
    C = np.random.default_rng(1).normal(size=(harmonics.size, 2))
    values = {k: harmonics.values(moved(u, t[:, 0], k * h)) @ C for k in (-2, -1, 0, 1, 2)}
    Y, first = harmonics.along(u, t)
    second = harmonics.second_along(u, t, C)
    np.testing.assert_allclose(Y @ C, values[0], atol=1e-13)
    slope = (8 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12 * h)
    bend = (16 * (values[1] + values[-1]) - (values[2] + values[-2]) - 30 * values[0]) / (12 * h**2)
    np.testing.assert_allclose(first[:, 0] @ C, slope, atol=1e-8)
    np.testing.assert_allclose(second[:, 0, 0], bend, atol=1e-6)
    np.testing.assert_allclose(second[:, 0, 1], second[:, 1, 0], atol=1e-12)


def test_the_laplacian_has_their_degree_as_its_eigenvalue():
    u = directions(9)
    harmonics = Harmonics(16, 5)
    hessian = harmonics.second_along(u, tangent_pair(u), np.eye(harmonics.size))
    degrees, _ = harmonics.labels
    expected = -degrees * (degrees + 1) * harmonics.values(u)
    np.testing.assert_allclose(hessian[:, 0, 0] + hessian[:, 1, 1], expected, atol=1e-10)


def test_gradients_are_tangent_and_agree_with_derivatives():
    u = directions(9)
    t = tangent_pair(u)
    Y, D = Harmonics(6, 4).gradients(u)
    np.testing.assert_allclose(np.einsum("ni,nis->ns", u, D), 0.0, atol=1e-12)
    values, first = Harmonics(6, 4).along(u, t)
    np.testing.assert_array_equal(Y, values)
    np.testing.assert_allclose(t @ D, first, atol=1e-12)


@pytest.mark.parametrize(("degree", "order"), [(3, 4), (2, -1)])
def test_an_impossible_order_is_refused(degree, order):
    with pytest.raises(ValueError, match=f"the order {order} is not between 0 and the degree {degree}"):
        Harmonics(degree, order)


def test_derivatives_of_several_functions() -> None:
    harmonics = Harmonics(7, 5)
    C = np.random.default_rng(3).normal(size=(harmonics.size, 2))
    u = fibonacci_directions(30)
    several = harmonics.derivatives(u, C)
    for c in range(2):
        for both, one in zip(several, harmonics.derivatives(u, C[:, c]), strict=True):
            assert np.array_equal(both[:, c], one)
