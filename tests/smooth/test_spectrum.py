"""What Fourier coefficients say of the errors of functions on grids: stated against true ones."""

import numpy as np
import pytest

from isoembed.meshing.sphere import gauss_rule
from isoembed.smooth.double_fourier import DoubleFourier
from isoembed.smooth.spectrum import Spectrum


def nodes(n, m, start=0.0):
    return (np.arange(n) + 0.5) * (np.pi / n), start + np.arange(m) * (2.0 * np.pi / m)


def on_grid(f, n, m, start=0.0):
    theta, phi = nodes(n, m, start)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    x = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)
    return theta, phi, f(x.reshape(-1, 3)).reshape(n, m, 1)


def errors(f, n, m, noise=None, start=0.0):
    """True and stated errors of the mean over the sphere, and at points."""
    theta, phi, values = on_grid(f, n, m, start)
    if noise is not None:
        values = values + noise(values.shape)
    series = DoubleFourier(theta, phi, values)
    u, weights = gauss_rule(64, 128)
    off = series.at(u)[:, 0] - f(u)
    return abs(weights @ off) / (4.0 * np.pi), np.abs(off).max(), Spectrum.of(series)


def rational(u):
    return 1.0 / (1.5 + u @ np.array([0.3, -0.5, 0.6]))


@pytest.mark.parametrize("n", [6, 8, 12, 16, 24, 32])
def test_what_is_beyond_the_grid(n):
    mean, pointwise, found = errors(rational, n, 2 * n)
    assert mean <= found.error.mean + 1e-15 and pointwise <= found.error.pointwise + 1e-14
    assert found.error.mean <= found.tail * 3.0 and found.error.pointwise <= 1e3 * pointwise + 1e-12


def test_averages_of_smooth_functions_are_much_better_than_values():
    found = errors(rational, 16, 32)[2].error
    assert found.mean < 1e-3 * found.pointwise


@pytest.mark.parametrize("n", [8, 10, 12, 16])
@pytest.mark.parametrize("m", [1, 2])
def test_a_slow_tail_behind_what_ends_before_the_grid_does(n, m):
    """The square of 1 + w^2 / 10 has degree four: what is left falls less than the grid shows."""
    for c, s in ((0.003, 3.0), (-0.01, 2.5), (0.001, 2.2)):

        def height(u):
            return np.sqrt(1.0 + (0.1 * u[:, 2] ** 2 + c / (s + u[:, 2])) ** 2)  # noqa: B023

        mean, _, found = errors(height, n, m * n if m > 1 else 1)
        assert mean <= found.error.mean + 1e-15


@pytest.mark.parametrize("size", [1e-10, 1e-2])
@pytest.mark.parametrize(("n", "m"), [(8, 1), (12, 24), (24, 1), (24, 48), (32, 32)])
def test_noise_is_seen_wherever_it_begins(n, m, size):
    def even(u):
        return 1.0 / (1.2 + u[:, 2] ** 2)

    ratios = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        mean, pointwise, found = errors(even, n, m, lambda shape: size * rng.normal(size=shape))  # noqa: B023
        ratios.append(mean / found.error.mean)
        assert pointwise <= 1.5 * found.error.pointwise
    assert max(ratios) < 1.0 and np.median(ratios) > 0.001


@pytest.mark.parametrize(("fold", "n", "m"), [(8, 24, 20), (4, 16, 12), (4, 16, 8)])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5 * np.pi])
def test_what_turns_too_fast_in_phi_is_seen_in_theta(fold, n, m, phase):
    def waves(u):
        wave = 0.2 * np.real((u[:, 0] + 1j * u[:, 1]) ** fold * np.exp(1j * phase))
        return np.exp(wave)

    mean, _, found = errors(waves, n, m)
    if (fold, m, phase) != (4, 8, 0.5 * np.pi):  # all nodes are on lines where the wave is zero
        assert mean <= found.error.mean


def test_few_angles_phi_are_not_trusted_where_nothing_depends_on_phi():
    def even(u):
        return 1.0 / (1.2 + u[:, 2] ** 2)

    few, one = errors(even, 24, 8)[2], errors(even, 24, 1)[2]
    assert few.error.mean > 1e-4 > 1e-10 > one.error.mean
    assert few.unseen == few.tail and one.unseen == 0.0


def test_one_wrong_value_and_kinks_are_within_the_errors():
    def outlier(shape):
        change = np.zeros(shape)
        change[7, 11] = 0.1
        return change

    mean, pointwise, found = errors(rational, 24, 48, outlier)
    assert mean <= found.error.mean <= 100.0 * mean and pointwise <= 5.0 * found.error.pointwise
    for n in (12, 24, 48):
        mean, pointwise, found = errors(lambda u: np.abs(u[:, 2] - 0.2) + u[:, 0], n, 2 * n)
        assert mean <= found.error.mean and pointwise <= 3.0 * found.error.pointwise


@pytest.mark.parametrize("scale", [2.0**-664, 2.0**-10, 2.0**498])
def test_any_unit(scale):
    theta, phi, values = on_grid(rational, 12, 24)
    one, other = (Spectrum.of(DoubleFourier(theta, phi, s * values)) for s in (1.0, scale))
    assert other.error.mean == pytest.approx(scale * one.error.mean, rel=1e-9)
    assert other.error.pointwise == pytest.approx(scale * one.error.pointwise, rel=1e-9)


def test_nothing_is_exact():
    theta, phi = nodes(8, 16)
    found = Spectrum.of(DoubleFourier(theta, phi, np.zeros((8, 16, 2))))
    assert found.tail == found.error.mean == found.error.pointwise == 0.0
