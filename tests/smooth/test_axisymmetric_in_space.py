"""Surfaces of revolution in hyperbolic and spherical space: closed forms, discarded coordinates, limits."""

from dataclasses import replace
from functools import cache
from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from isoembed.errors import InvalidMetric
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.least_hyperbolic import least_hyperbolic
from isoembed.space import Euclidean, Hyperbolic, Space, Spherical

THETA = np.linspace(0.0, pi, 61)
SPACES = [Hyperbolic(0.8), Hyperbolic(1e-9), Spherical(0.3)]


def spheroid(a, c, space):
    """The surface with the ambient coordinates (a sin t, c cos t) of its meridian, from its metric."""
    k = space.curvature

    def q_tt(t):
        x, y, dx, dy = a * np.sin(t), c * np.cos(t), a * np.cos(t), -c * np.sin(t)
        return dx**2 + dy**2 + k * (x * dx + y * dy) ** 2 / (1.0 - k * (x**2 + y**2))

    return AxisymmetricEmbedding.from_components(q_tt, lambda t: (a * np.sin(t)) ** 2, space=space)


@cache
def horizon(spin):
    return AxisymmetricEmbedding.of(KerrNewmanHorizon(1.0, spin))


def mass(spin, factor=1.0):
    """Kijowski, Liu and Yau's of the Kerr horizon in the least hyperbolic space, or another one."""
    r = 1.0 + sqrt(1.0 - spin * spin)
    least = (r * r - 3.0 * spin * spin) / (r * r + spin * spin) ** 2
    return replace(horizon(spin), space=Space(factor * least)).integrated_mean_curvature / (4.0 * pi)


@pytest.mark.parametrize(("space", "r"), [*zip(SPACES, (0.4, 1.5, 1.5), strict=True)])
def test_geodesic_spheres(space, r):
    sn, cs = float(space.sn(r)), float(space.cs(r))
    e = spheroid(sn, sn, space)
    assert e.embeds and e.negative_curvature == ()
    assert e.integrated_mean_curvature == pytest.approx(4.0 * pi * sn * cs, rel=1e-13)
    assert e.bands[0].height == pytest.approx(2.0 * r, rel=1e-13)
    np.testing.assert_allclose(e.mean_curvature(THETA), cs / sn, rtol=1e-9)
    assert e.greatest_curvature == pytest.approx(1.0 / sn**2, rel=1e-9)


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize(("a", "c"), [(0.5, 1.2), (1.2, 0.5)])
def test_discarded_coordinates(space, a, c):
    e = spheroid(a, c, space)
    np.testing.assert_allclose(e.rho(THETA), a * np.sin(THETA), atol=1e-14)
    np.testing.assert_allclose(e.z(THETA), c * np.cos(THETA), atol=1e-12)
    u = np.stack([np.sin(THETA) * np.cos(0.7), np.sin(THETA) * np.sin(0.7), np.cos(THETA)], axis=1)
    np.testing.assert_allclose(e.points(u), u * [a, a, c], atol=1e-12)
    vertices, _ = e.bands[0].mesh(12)
    np.testing.assert_allclose(((vertices / [a, a, c]) ** 2).sum(axis=1), 1.0, atol=1e-11)


@pytest.mark.parametrize("space", SPACES)
def test_the_integral_is_that_of_the_curvatures(space):
    e = spheroid(0.7, 1.1, space)

    def density(t):
        area = np.sqrt(e.T(np.cos([t]))[0]) * e.unit * e.rho([t])[0]
        return 2.0 * pi * area * e.mean_curvature([t])[0]

    assert e.integrated_mean_curvature == pytest.approx(quad(density, 0.0, pi)[0], rel=1e-9)


KERR = {0.9: 1.8343379378, 0.95: 1.9343168808, 0.99: 2.0102107853, 1.0: 2.019656395202}


@pytest.mark.parametrize(
    "spin", [0.95, 1.0, *(pytest.param(spin, marks=pytest.mark.slow) for spin in (0.9, 0.99))]
)
def test_kerr_horizons_beyond_smarrs_limit(spin):
    # M. Dunajski and P. Tod, arXiv:2107.12400, print five digits at the ends.
    assert mass(spin) == pytest.approx(KERR[spin], abs=1e-10)
    least = least_hyperbolic(KerrNewmanHorizon(1.0, spin))
    r2, a2 = (1.0 + sqrt(1.0 - spin**2)) ** 2, spin**2
    for found in (least.space.curvature, least.gaussian_curvature, least.of_revolution):
        assert found == pytest.approx((r2 - 3.0 * a2) / (r2 + a2) ** 2, abs=1e-11)
    e = replace(horizon(spin), space=least.space)
    assert e.embeds
    assert e.integrated_mean_curvature / (4.0 * pi) == pytest.approx(KERR[spin], abs=1e-10)
    assert least.explanation.startswith("the metric embeds in hyperbolic space of curvature -0.")


def test_the_mass_depends_on_the_curvature_of_space():
    assert mass(0.95, factor=2.0) == pytest.approx(2.165205282136, abs=1e-11)


def test_the_greatest_mass():
    found = minimize_scalar(
        lambda j: -mass(j), bounds=(0.9985, 0.9996), method="bounded", options={"xatol": 1e-9}
    )
    assert found.x == pytest.approx(0.99906997, abs=1e-6)
    assert -found.fun == pytest.approx(2.0222306427, abs=1e-10)


def test_smarrs_limit_from_both_sides():
    limit, exact = sqrt(3.0) / 2.0, 1.76569172
    assert mass(limit) == pytest.approx(exact, abs=2e-9)
    for step in (1e-4, 1e-6):
        below = horizon(limit - step).integrated_mean_curvature / (4.0 * pi)
        assert below == pytest.approx(exact, abs=2.0 * step)
        assert mass(limit + step) == pytest.approx(exact, abs=5.0 * step)
    least = least_hyperbolic(KerrNewmanHorizon(1.0, limit - 1e-4))
    assert least.space == Euclidean() and least.of_revolution > 0.0
    assert least.explanation.startswith(
        "the metric embeds in Euclidean space: the least Gaussian curvature is"
    )


def test_flat_space_is_the_limit_at_a_linear_rate():
    flat = horizon(0.5).integrated_mean_curvature
    for sign in (-1.0, 1.0):
        changes = [
            replace(horizon(0.5), space=Space(sign * k)).integrated_mean_curvature - flat
            for k in (1e-3, 1e-5, 1e-7)
        ]
        assert changes[0] / changes[1] == pytest.approx(100.0, rel=0.02)
        assert changes[1] / changes[2] == pytest.approx(100.0, rel=1e-4)


def test_too_little_curvature_leaves_bands():
    e = replace(horizon(0.95), space=Space(0.5 * horizon(0.95).greatest_curvature))
    assert not e.embeds
    ((start, _),) = [(band.start, band.stop) for band in e.bands]
    slope = np.gradient(e.rho(start + np.array([-1e-5, 0.0, 1e-5])), 1e-5)[1]
    speed = np.sqrt(e.T(np.cos([start]))[0]) * e.unit
    assert (slope / speed) ** 2 == pytest.approx(1.0 - e.space.curvature * e.rho(start)[0] ** 2, abs=1e-8)
    sentence = (
        r"no surface of revolution in hyperbolic space of curvature -0\.0715374793 has this metric for"
        r" theta < 0\.676\d+ and .* 0\.676\d+ < theta < 2\.465\d+ embeds, 77\.\d+ % of the area;"
        r" the whole surface embeds in a space of curvature -0\.143074959 or less"
    )
    with pytest.raises(InvalidMetric, match=sentence):
        _ = e.integrated_mean_curvature


def test_no_hemisphere_has_what_is_longer_than_half_of_a_great_circle():
    # A tube of radius .2 about an arc of 3.4 with rounded ends, as (distance from the axis, along it).
    h = 1.7

    def q_tt(t):
        r_t = 0.2 * np.cos(t)
        return r_t**2 + np.cos(0.2 * np.sin(t)) ** 2 * (h * np.sin(t)) ** 2

    e = AxisymmetricEmbedding.from_components(q_tt, lambda t: np.sin(0.2 * np.sin(t)) ** 2, space=Spherical())
    assert e.embeds and e.bands[0].height == pytest.approx(2.0 * h, rel=1e-12)
    with pytest.raises(InvalidMetric, match=r"the surface is 3\.4 long, more than half of a great circle"):
        e.z(1.0)


def test_the_greatest_curvature_of_space_is_found_between_samples():
    e = AxisymmetricEmbedding.from_components(
        lambda t: np.cos(t) ** 2 + np.sin(t) ** 2 * (np.cos(t) - 0.4567) ** 2, lambda t: np.sin(t) ** 2
    )
    x = np.linspace(-1.0, 1.0, 400001)
    G = (x - 0.4567) ** 2
    least = (G / (x**2 + (1.0 - x**2) * G)).min()
    assert e.greatest_curvature == pytest.approx(least, abs=1e-10)


def test_a_sphere_larger_than_those_of_the_space_embeds_nowhere():
    """K is less than the curvature of space, as it is at the poles of no surface of revolution."""
    radius = 1.2
    sphere = AxisymmetricEmbedding.from_components(
        lambda t: radius**2 + 0 * t, lambda t: (radius * np.sin(t)) ** 2, space=Spherical(1.0)
    )
    assert not sphere.embeds
    assert "has this metric for all theta: there q_tt" in sphere.explanation
    assert "(K < k for all theta;" in sphere.explanation
