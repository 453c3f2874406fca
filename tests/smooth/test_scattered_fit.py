"""Harmonics fitted to scattered values with outliers and noise, against functions that are known."""

import numpy as np
import pytest

from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating, fitted, white


def scattered(n, seed=1):
    u = np.random.default_rng(seed).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def smooth(u):
    return 2.0 + 0.3 * u[:, 2] ** 2 + 0.2 * u[:, 0] * u[:, 1] * u[:, 2]


def fit_of(u, values):
    return fitted(u, values, np.full(len(u), 4.0 * np.pi / len(u)))


def error(fit, exact=smooth):
    u = scattered(200, seed=99)
    return np.abs(fit.harmonics.values(u) @ fit.coefficients - exact(u)).max()


@pytest.mark.parametrize("off", [1e-7, 1e-3, 0.2, -0.5])
@pytest.mark.parametrize("n", [60, 600])
def test_one_outlier_is_left_out(n, off):
    u = scattered(n)
    values = smooth(u)
    values[17] *= 1.0 + off
    fit = fit_of(u, values)
    assert fit.left_out.tolist() == [17]
    assert fit.apart == pytest.approx(values[17] - smooth(u)[17], rel=1e-2)
    assert error(fit) < 1e-12


def test_several_outliers_of_different_sizes_are_left_out():
    u = scattered(600)
    noise = 1e-4 * np.random.default_rng(3).normal(size=600)
    values = smooth(u) + noise
    values[[5, 100, 321]] += [0.3, -0.01, 0.003]
    fit = fit_of(u, values)
    assert sorted(fit.left_out.tolist()) == [5, 100, 321]
    assert error(fit) < 1e-4


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_outliers(seed):
    u = scattered(1000, seed)
    assert len(fit_of(u, smooth(u) + 1e-3 * np.random.default_rng(seed).normal(size=1000)).left_out) == 0


@pytest.mark.parametrize("seed", range(4))
def test_what_is_not_resolved_is_no_outlier(seed):
    u = scattered(600, seed)
    bump = 0.2 * np.exp(-20.0 * (1.0 - u @ [0.6, 0.0, 0.8]))
    assert len(fit_of(u[::2], (smooth(u) + bump)[::2]).left_out) == 0


def test_where_outliers_are_many_they_stay():
    u, random = scattered(600), np.random.default_rng(4)
    values = smooth(u)
    values[random.choice(600, 30, replace=False)] *= 1.1
    fit = fit_of(u, values)
    assert len(fit.left_out) == 0
    deviations = fit.deviations @ deviating(fit.harmonics).values(scattered(200)).T
    assert error(fit) < 6.0 * np.sqrt(np.mean(deviations**2, axis=0)).max()


@pytest.mark.parametrize("noise", [1e-9, 1e-3])
def test_deviations_are_as_large_as_the_error(noise):
    n = 500
    apart, u = [], scattered(n)
    for seed in range(10):
        fit = fit_of(u, smooth(u) + noise * np.random.default_rng(seed).normal(size=n))
        where = scattered(100, seed=7)
        missed = fit.harmonics.values(where) @ fit.coefficients - smooth(where)
        drawn = fit.deviations @ deviating(fit.harmonics).values(where).T
        apart.append(np.sqrt(np.mean(missed**2) / np.mean(drawn**2)))
    assert 0.1 < np.median(apart) < 1.0
    assert max(apart) < 1.5


def test_what_is_not_resolved_deviates_as_much_as_it_is_missed():
    u, wrinkles = scattered(120), Harmonics(12, 12)
    coefficients = np.zeros(wrinkles.size)
    coefficients[wrinkles.labels[0] == 12] = 0.01 * np.random.default_rng(5).normal(size=25)

    def wrinkled(u):
        return smooth(u) + wrinkles.values(u) @ coefficients

    fit = fit_of(u, wrinkled(u))
    drawn = fit.deviations @ deviating(fit.harmonics).values(u).T
    assert error(fit, wrinkled) < 3.0 * np.abs(drawn).max()


def test_wrinkles_beyond_a_gap_in_the_degrees_are_no_noise():
    u, wrinkles = scattered(600), Harmonics(12, 12)
    coefficients = np.where(wrinkles.labels[0] > 9, 0.01, 0.0)

    def wrinkled(u):
        return smooth(u) + wrinkles.values(u) @ coefficients

    fit = fit_of(u, wrinkled(u))
    assert fit.harmonics.degree == 12
    assert error(fit, wrinkled) < 1e-12


def test_white_deviations():
    harmonics = Harmonics(6, 2)
    drawn = white(harmonics, 1e-3) @ deviating(harmonics).values(scattered(400)).T
    assert np.sqrt(np.mean(drawn**2)) == pytest.approx(1e-3, rel=0.1)
    (nothing,) = white(harmonics, 0.0)
    assert not nothing.any()
