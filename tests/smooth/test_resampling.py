"""Truncation errors of averages from coarser grids, against true ones."""

import numpy as np
import pytest

from isoembed.smooth.double_fourier import DoubleFourier
from isoembed.smooth.resampling import truncation


def nodes(kind, n):
    return {
        "cell-centered": (np.arange(n) + 0.5) * (np.pi / n),
        "inner": np.arange(1, n + 1) * (np.pi / (n + 1)),
        "gauss": np.arccos(np.polynomial.legendre.leggauss(n)[0])[::-1],
    }[kind]


def root(values):
    return np.sqrt(values)


def spheroid(kind, n, m):
    """1 + 8 z^2; the average of its root is (arsinh(s) / s + 3) / 2, s^2 = 8."""
    theta, phi = nodes(kind, n), np.arange(m) * (2.0 * np.pi / m)
    values = 1.0 + 8.0 * np.cos(theta)[:, None, None] ** 2 * np.ones((1, m, 1))
    return DoubleFourier(theta, phi, values)


def rational(kind, n):
    """1 / (1.3 + z), whose average is log(2.3 / 0.3) / 2."""
    theta = nodes(kind, n)
    return DoubleFourier(theta, np.zeros(1), 1.0 / (1.3 + np.cos(theta))[:, None, None])


def average(series, derived):
    z, weights = np.polynomial.legendre.leggauss(200)
    return float(0.5 * weights @ derived(series.on(np.arccos(z), np.zeros(1))[:, 0])[:, 0])


@pytest.mark.parametrize("kind", ["cell-centered", "inner"])
@pytest.mark.parametrize("n", [6, 8, 10, 12, 16, 20])
def test_the_error_of_an_average_is_known_within_a_factor(kind, n):
    series = rational(kind, n)
    true = abs(average(series, np.asarray) - 0.5 * np.log(2.3 / 0.3))
    assert true < 3.0 * truncation(series, np.asarray) < 300.0 * true


@pytest.mark.parametrize("kind", ["cell-centered", "inner", "gauss"])
@pytest.mark.parametrize("n", [8, 12, 16])
def test_of_what_the_grid_holds_nothing_is_lost(kind, n):
    series = spheroid(kind, n, 2 * n)
    exact = 0.5 * (np.arcsinh(np.sqrt(8.0)) / np.sqrt(8.0) + 3.0)
    assert abs(average(series, root) - exact) < 1e-13
    assert truncation(series, root) < 1e-13


def test_derived_functions_alias_where_the_given_ones_do_not():
    """On Gauss-Legendre nodes averages are exact up to twice the degree, those of roots are not."""
    series = rational("gauss", 12)
    exact = 0.5 * 2.0 * (np.sqrt(1.0 / 0.3) * 0.3 - np.sqrt(1.0 / 2.3) * 2.3)
    true = abs(average(series, root) + exact)
    assert truncation(series, np.asarray) < 1e-12 < true < 3.0 * truncation(series, root)


def test_any_turn_about_the_axis():
    n, m = 12, 24
    theta, phi = nodes("cell-centered", n), np.arange(m) * (2.0 * np.pi / m)
    found = []
    for start in (0.0, 1.0):
        values = 1.0 / (1.4 + np.sin(theta)[:, None, None] * np.cos(phi)[None, :, None])
        found.append(truncation(DoubleFourier(theta, phi + start, values), np.asarray))
    assert found[0] == pytest.approx(found[1], rel=1e-6)
