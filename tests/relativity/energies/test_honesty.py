"""Stated errors where the data are noisy, rough, aliased or wrong: they hold, or there is a refusal."""

import numpy as np
import pytest

from isoembed.errors import InvalidMetric
from isoembed.relativity import KerrSchild, StarSurface, SurfaceData, embed_surface
from isoembed.relativity.energies.smooth_energies import intrinsic_energies
from isoembed.smooth import GridMetric

RADIUS, MASS = 4.0, 1.0
K = 2.0 / RADIUS * np.sqrt(1.0 - 2.0 * MASS / RADIUS)  # in the static slice, where Hawking's energy is M
HONEST = 3.0  # true errors over stated ones, at most


def angles(n, m):
    """Of a cell-centered grid, as columns and rows."""
    return (np.arange(n) + 0.5)[:, None] * (np.pi / n), np.arange(m)[None] * (2.0 * np.pi / m)


def surface(theta, phi, k=None, noise=0.0, seed=0):
    """The sphere, with k (n, m) and with noise in its metric."""
    one = np.ones(np.broadcast(theta, phi).shape)
    q = [RADIUS**2 * one, 0.0 * one, RADIUS**2 * np.sin(theta) ** 2 * one]
    rng = np.random.default_rng(seed)
    q = [c + noise * RADIUS**2 * np.sin(theta) ** i * rng.normal(size=one.shape) for i, c in enumerate(q)]
    return SurfaceData.from_grid(theta[:, 0], phi[0], q, K * one if k is None else k)


def holds(estimate, exact):
    return abs(estimate.value - exact) <= HONEST * estimate.error


@pytest.mark.parametrize("noise", [1e-6, 1e-4, 1e-2])
def test_noise_in_k(noise):
    theta, phi = angles(16, 32)
    for seed in range(5):
        k = K * (1.0 + noise * np.random.default_rng(seed).normal(size=(16, 32)))
        hawking = intrinsic_energies(surface(theta, phi, k)).hawking
        assert holds(hawking, MASS) and hawking.error < 10.0 * noise


def test_noise_in_the_metric_and_more_in_k():
    theta, phi = angles(16, 32)
    for seed in range(5):
        k = K * (1.0 + 1e-4 * np.random.default_rng(100 + seed).normal(size=(16, 32)))
        found = intrinsic_energies(surface(theta, phi, k, noise=1e-6, seed=seed))
        assert holds(found.hawking, MASS) and holds(found.area, 4.0 * np.pi * RADIUS**2)
        assert found.hawking.error < 1e-3


@pytest.mark.parametrize("n", [8, 12, 16, 24])
def test_k_that_its_grid_hardly_resolves(n):
    """int k dA of 1 / (1 + (c z)^2) is 4 pi r^2 arctan(c) / c, and that of its square known, too."""
    c = 4.0
    theta, phi = angles(n, 2 * n)
    k = K * (1.0 + 1.0 / (1.0 + (c * np.cos(theta)) ** 2) + 0.0 * phi)
    first = np.arctan(c) / c
    second = 0.5 * (first + 1.0 / (1.0 + c * c))
    mean = K**2 * (1.0 + 2.0 * first + second)
    exact = 0.5 * RADIUS * (1.0 - RADIUS**2 / 4.0 * mean)
    try:
        hawking = intrinsic_energies(surface(theta, phi, k)).hawking
    except InvalidMetric as refusal:
        assert "k" in str(refusal) and n < 16
    else:
        assert holds(hawking, exact)
        assert hawking.error < 50.0 * abs(hawking.value - exact)


def test_k_the_wrong_way_round():
    """Angles taken for each other on a square grid."""
    theta, phi = angles(24, 24)
    k = K * (1.0 + 0.3 * np.cos(theta) + 0.2 * np.sin(theta) * np.cos(phi))
    exact = 0.5 * RADIUS * (1.0 - RADIUS**2 / 4.0 * K**2 * (1.0 + (0.09 + 0.04) / 3.0))
    assert holds(intrinsic_energies(surface(theta, phi, k)).hawking, exact)
    try:
        wrong = intrinsic_energies(surface(theta, phi, k.T)).hawking
    except InvalidMetric as refusal:
        assert "k" in str(refusal)
    else:
        assert holds(wrong, exact)


@pytest.mark.parametrize(("fold", "m", "size"), [(8, 20, 0.1), (8, 16, 0.1), (4, 8, 0.3), (4, 10, 0.3)])
@pytest.mark.parametrize("phase", [0.0, 0.2])
def test_waves_that_the_angles_phi_alias(fold, m, size, phase):
    """The round metric, its height changed by a wave: z -> z + size Re (x + i y)^fold."""
    theta, phi = angles(24, m)
    sin, cos = np.sin(theta), np.cos(theta)
    wave = np.cos(fold * (phi + phase)) + 0.0 * theta
    z, rho = cos + size * sin**fold * wave, sin
    z_t = -sin + size * fold * sin ** (fold - 1) * cos * wave
    z_p = -size * fold * sin**fold * np.sin(fold * (phi + phase))
    # v = (rho, phi, z) on rays: a map of the sphere, whose image has the round metric.
    r2 = rho**2 + z**2
    turn = (z * cos - rho * z_t) / r2  # d(polar angle)
    across = -rho * z_p / r2
    q = [turn**2, turn * across, across**2 + rho**2 / r2]
    one = np.ones(wave.shape)
    try:
        data = SurfaceData.from_grid(theta[:, 0], phi[0], [RADIUS**2 * c * one for c in q], K * one)
    except InvalidMetric as refusal:
        assert "coarse" in str(refusal)
        return
    found = intrinsic_energies(data)
    assert holds(found.area, 4.0 * np.pi * RADIUS**2) and holds(found.hawking, MASS)
    assert m <= 2 * fold or found.hawking.error < 0.03  # what is resolved is known


def test_errors_of_a_grid_need_not_be_asked_for():
    """Kerr's r = const in its slice, on a grid that does not resolve it to rounding."""
    a, r = 0.8, 3.0
    theta, phi = angles(9, 18)
    sigma = r * r + (a * np.cos(theta)) ** 2 + 0.0 * phi
    s2 = np.sin(theta) ** 2
    around = (r * r + a * a + 2.0 * r * a * a * s2 / sigma) * s2
    data = SurfaceData(GridMetric(theta[:, 0], phi[0], sigma, 0.0 * sigma, around))
    assert holds(intrinsic_energies(data).area, 120.12242026143980)
    found = embed_surface(data).energies.integrated_mean_curvature
    assert holds(found, 38.873468325120506) and found.error < 1e-4


def test_one_point_of_many_is_wrong():
    rng = np.random.default_rng(1)
    u = rng.normal(size=(600, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    points = RADIUS * u
    points[17] *= 1.2
    found = embed_surface(
        StarSurface.from_points(points, (0, 0, 0)).data(KerrSchild(MASS, (0, 0, 0)))
    ).energies
    assert holds(found.area, 4.0 * np.pi * RADIUS**2) and holds(found.hawking, MASS)
    assert holds(found.liu_yau, RADIUS * (1.0 - np.sqrt(1.0 - 2.0 * MASS / RADIUS)))
    assert found.liu_yau.error < 1e-9


def test_two_nodes_say_nothing_of_noise():
    theta = np.linspace(0.0, np.pi, 4)[:, None]
    one = np.ones((4, 1))
    q = [one, 0.0 * one, np.sin(theta) ** 2]
    assert holds(intrinsic_energies(SurfaceData.from_grid(theta[:, 0], [0.0], q)).area, 4.0 * np.pi)
    with pytest.raises(InvalidMetric, match=r"k is uncertain by .* the grid is too coarse"):
        SurfaceData.from_grid(theta[:, 0], [0.0], q, k=2.0 * one)


@pytest.mark.parametrize("n", [12, 14, 16])
def test_uniform_nodes_without_the_poles(n):
    """What they miss of a horizon of Kerr, a = 0.8, aliases onto low degrees, and so onto averages."""
    theta, phi = np.linspace(0.0, np.pi, n + 2)[1:-1, None], angles(n, 2 * n)[1]
    sigma = 1.6**2 + (0.8 * np.cos(theta)) ** 2 + 0.0 * phi
    q = [sigma, 0.0 * sigma, (3.2 * np.sin(theta)) ** 2 / sigma]
    area = intrinsic_energies(SurfaceData.from_grid(theta[:, 0], phi[0], q)).area
    assert abs(area.value - 4.0 * np.pi * 3.2) <= area.error < 1e-5
