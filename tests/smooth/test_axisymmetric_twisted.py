"""Axisymmetric metrics with q_tp: twisted spheroids, and horizons and spheres in slices that rotate."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

from isoembed.errors import InvalidMetric
from isoembed.relativity import (
    KerrNewmanHorizon,
    KerrSchild,
    MappedSurface,
    StarSurface,
    SurfaceData,
    embed_surface,
)
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.least_hyperbolic import least_hyperbolic
from isoembed.smooth.two_metric import AngleMetric, PulledBack
from isoembed.space import Euclidean, Hyperbolic

THETA = np.linspace(0.0, pi, 41)
TILT = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])  # takes z to (.8, 0, .6)


def twisted_spheroid(a, c, turn):
    """The metric of the spheroid whose circle at theta is turned by psi = turn (1 - cos + sin^2 / 3)."""

    def components(t, _):
        slope = turn * np.sin(t) * (1.0 + 2.0 / 3.0 * np.cos(t))
        rho2 = (a * np.sin(t)) ** 2
        return (a * np.cos(t)) ** 2 + (c * np.sin(t)) ** 2 + rho2 * slope**2, rho2 * slope, rho2

    return AngleMetric(components)


def boosted_horizon(a, v, axes=np.eye(3)):  # noqa: B008 (not changed)
    """The Kerr horizon, M = 1, at one time of an observer who moves along its spin.

    In Kerr-Schild's coordinates it is a spheroid at all times t; here t = v z.
    """
    r = 1.0 + sqrt(1.0 - a * a)
    s = sqrt(r * r + a * a)

    def differential(u):
        return np.broadcast_to(np.diag([s, s, r]) @ axes.T, (len(u), 3, 3))

    def ambient(u):
        x, y, z = (u @ axes * [s, s, r]).T
        l = np.stack([(r * x + a * y) / s**2, (r * y - a * x) / s**2, z / r + v], axis=1)
        H = r**3 / (r**4 + (a * z) ** 2)
        return np.diag([1.0, 1.0, 1.0 - v * v]) + (2.0 * H)[:, None, None] * l[:, :, None] * l[:, None, :]

    return PulledBack(differential, ambient)


def ergosurface(a, axes=np.eye(3)):  # noqa: B008 (not changed)
    """Where the time translation of Kerr-Schild's coordinates is null: r = 1 + sqrt(1 - a^2 cos^2)."""

    def points(u):
        x, y, z = (u @ axes).T
        r = 1.0 + np.sqrt(1.0 - (a * z) ** 2)
        return np.stack([np.hypot(r, a) * x, np.hypot(r, a) * y, r * z], axis=1) @ axes.T

    return MappedSurface.from_map(points).data(KerrSchild(1.0, tuple(axes @ [0.0, 0.0, a])))


@pytest.mark.parametrize("turn", [1e-13, 1e-6, 0.7, -3.0])
def test_twisted_spheroids(turn):
    a, c = 1.0, 1.4
    e = AxisymmetricEmbedding.of(twisted_spheroid(a, c, turn))
    np.testing.assert_allclose(
        e.twist(THETA), turn * (1.0 - np.cos(THETA) + np.sin(THETA) ** 2 / 3.0), atol=1e-13
    )
    np.testing.assert_allclose(e.rho(THETA), a * np.sin(THETA), atol=1e-14)
    np.testing.assert_allclose(e.z(THETA), c * np.cos(THETA), atol=1e-13)
    plain = AxisymmetricEmbedding.of(twisted_spheroid(a, c, 0.0))
    np.testing.assert_array_equal(plain.twist(THETA), 0.0)
    assert e.integrated_mean_curvature == pytest.approx(plain.integrated_mean_curvature, rel=1e-14)
    assert e.greatest_curvature == pytest.approx(plain.greatest_curvature, rel=1e-13)
    np.testing.assert_allclose(e.mean_curvature(THETA), plain.mean_curvature(THETA), rtol=1e-9)


@pytest.mark.parametrize("turn", [0.7, -3.0])
def test_distances_between_the_points_are_those_of_the_metric(turn):
    metric = twisted_spheroid(1.0, 1.4, turn)
    e = AxisymmetricEmbedding.of(metric)
    rng = np.random.default_rng(0)
    u = np.concatenate([rng.normal(size=(40, 3)), [[0.0, 0.0, 1.0], [1e-3, 0.0, -1.0]]])
    u /= np.linalg.norm(u, axis=1)[:, None]
    w = np.cross(u, rng.normal(size=u.shape))
    step = 1e-3

    def moved(t):
        v = u + t * w
        return e.points(v / np.linalg.norm(v, axis=1)[:, None])

    slope = (8.0 * (moved(step) - moved(-step)) - (moved(2.0 * step) - moved(-2.0 * step))) / (12.0 * step)
    np.testing.assert_allclose(
        np.einsum("ni,ni->n", slope, slope), np.einsum("ni,nij,nj->n", w, metric.tensor(u), w), rtol=1e-8
    )


def test_a_component_that_is_not_smooth_at_the_poles_is_refused():
    metric = AngleMetric(lambda t, _: (1.0 + 0.0 * t, 0.1 * np.sin(t) ** 2, np.sin(t) ** 2))
    with pytest.raises(InvalidMetric, match=r"not smooth at the south pole: q_tp sin\(theta\) / q_pp = 0\.0"):
        AxisymmetricEmbedding.of(metric)


@pytest.mark.slow
def test_a_horizon_boosted_along_its_spin_is_the_one_at_rest():
    metric = boosted_horizon(0.95, 0.6, TILT)
    surface = embed_surface(SurfaceData(metric, marginal=True), space="hyperbolic")
    r2, a2 = (1.0 + sqrt(1.0 - 0.95**2)) ** 2, 0.95**2
    assert surface.space.curvature == pytest.approx((r2 - 3.0 * a2) / (r2 + a2) ** 2, abs=1e-11)
    energy = surface.energies.liu_yau
    assert energy.value == pytest.approx(1.9343168808, abs=1e-9)
    assert abs(energy.value - 1.9343168808) <= energy.error + 5e-11


def test_its_bands_are_those_at_rest():
    e, rest = (
        AxisymmetricEmbedding.of(m) for m in (boosted_horizon(0.95, 0.6), KerrNewmanHorizon(1.0, 0.95))
    )
    assert not e.embeds and len(e.bands) == len(rest.bands)
    for band, other in zip(e.bands, rest.bands, strict=True):
        assert band.area == pytest.approx(other.area, rel=1e-10)
        assert band.integrated_mean_curvature == pytest.approx(other.integrated_mean_curvature, rel=1e-9)
    assert e.explanation.startswith("no surface of revolution has this metric for theta < 0.896")


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.9), pytest.param((0.0, 0.54, 0.72), marks=pytest.mark.slow)])
def test_spheres_in_slices_that_rotate_take_euclidean_space(spin):
    data = StarSurface.sphere((0.0, 0.0, 0.0), 1.7).data(KerrSchild(1.0, spin))
    least = least_hyperbolic(data.metric)
    assert least.space == Euclidean() and least.of_revolution > least.gaussian_curvature > 0.0


def meridian(a):
    """The functions rho^2, its derivative and q_tt - q_tp^2 / q_pp of t of the ergosurface, Kerr-Schild."""

    def at(t):
        c, s = np.cos(t), np.sin(t)
        root = np.sqrt(1.0 - (a * c) ** 2)
        r, r_t = 1.0 + root, a * a * c * s / root
        R, sigma = np.hypot(r, a), r * r + (a * c) ** 2
        H = r / sigma
        # The null form along the surface: l = dr - a s^2 dphi, with phi of Kerr's own coordinates.
        pp = R * R * s * s + 2.0 * H * (a * s * s) ** 2
        flat = (r * r_t / R * s + R * c) ** 2 + (r_t * c - r * s) ** 2
        # x + i y = R s exp(i phi): l = (r x + a y) dx / R^2 + ... + z dz / r.
        l_t = r * s * (r * r_t / R * s + R * c) / R + c * (r_t * c - r * s)
        l_p = -a * s * s
        tt, tp = flat + 2.0 * H * l_t**2, 2.0 * H * l_t * l_p
        return pp, tt - tp * tp / pp

    return at


@pytest.mark.slow
def test_an_ergosurface_in_hyperbolic_space():
    surface = embed_surface(ergosurface(0.8), space="hyperbolic")
    at, k = meridian(0.8), surface.space.curvature
    h = 1e-5

    def density(t):
        rho = [np.sqrt(at(t + j * h)[0]) for j in (-2, -1, 0, 1, 2)]
        slope = (8.0 * (rho[3] - rho[1]) - (rho[4] - rho[0])) / (12.0 * h)
        bent = k * rho[2] ** 2
        fall = np.sqrt(max(at(t)[1] * (1.0 - bent) - slope**2, 0.0))
        return np.pi * (fall * (1.0 - 2.0 * bent) / (1.0 - bent) - np.arctan2(fall, slope) * slope)

    value = quad(density, 0.0, pi, epsabs=1e-9, limit=200, points=[0.5 * pi])[0]
    energies = surface.energies
    assert energies.integrated_mean_curvature.value == pytest.approx(value, abs=1e-7)
    assert energies.integrated_mean_curvature.error < 1e-7


def test_vertices_and_fields_stay_at_their_points():
    data = ergosurface(0.8)
    curved = embed_surface(data, space=Hyperbolic(0.4))
    profile = AxisymmetricEmbedding.of(data.metric, space=curved.space)
    tables = curved.mesh(200)
    u = curved.embedding.triangulated(200).directions
    np.testing.assert_allclose(
        tables["mean_curvature"], profile.mean_curvature(np.arccos(u[:, 2])), rtol=1e-6
    )
    # Up to a rotation the points are those of the profile: not so without its twist.
    p, x = profile.points(u), curved.embedding.points(u)
    np.testing.assert_allclose(p @ p.T, x @ x.T, atol=1e-7)
    turned = np.stack([np.hypot(p[:, 0], p[:, 1]) * u[:, i] / np.hypot(u[:, 0], u[:, 1]) for i in (0, 1)], 1)
    assert np.abs(turned @ turned.T - p[:, :2] @ p[:, :2].T).max() > 0.01
