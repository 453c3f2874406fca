"""Circumferences and multipoles of horizons, against closed forms of Kerr's."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ellipe

from isoembed.errors import NotEmbedded
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import (
    CoordinateShape,
    HorizonShape,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    energy_table,
    find_spin,
    horizon_data,
    unembedded_report,
)
from isoembed.relativity.horizons.circumferences import Circumferences
from isoembed.relativity.horizons.horizon_shape import shape_lines
from isoembed.relativity.horizons.invariant_coordinate import InvariantCoordinate
from isoembed.relativity.horizons.multipoles import Multipoles
from isoembed.smooth import AngleMetric, GridMetric, Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import PulledBack
from isoembed.smooth.uncertain import Uncertainty
from isoembed.space import Euclidean

ATTEMPT = SimpleNamespace(space=Euclidean(), hindrance="K < 0 at a pole")
SPINS = (0.0, 0.3, 0.6, 0.9, 0.99)


def polar(a):
    """Length of the closed meridian of a horizon of mass 1."""
    squared = 2.0 * (1.0 + np.sqrt(1.0 - a * a))  # r^2 + a^2
    return 4.0 * np.sqrt(squared) * ellipe(a * a / squared)


def moments(a):
    """I_n + i L_n of a horizon of mass 1: Psi_2 = -1 / (r - i a zeta)^3, and dA = (r^2 + a^2) dzeta dphi."""
    r = 1.0 + np.sqrt(1.0 - a * a)
    x, weights = np.polynomial.legendre.leggauss(200)
    legendre = np.polynomial.legendre.legvander(x, 8)
    integrals = (weights / (r - 1j * a * x) ** 3) @ legendre
    return 2.0 * np.pi * (r * r + a * a) * np.sqrt((2.0 * np.arange(9) + 1.0) / (4.0 * np.pi)) * integrals


def values(estimates):
    return np.array([e.value for e in estimates])


def errors(estimates):
    return np.array([e.error for e in estimates])


def in_boyer_lindquist(a, unit):
    return KerrNewmanHorizon(unit, a * unit).data()


def in_kerr_schild(a, unit):
    geometry = KerrSchild(unit, (0.0, 0.0, a * unit))
    return StarSurface.from_radius(geometry.spheroid(geometry.horizon)).data(
        geometry, (0, 0, 1), marginal=True
    )


@pytest.mark.parametrize("a", SPINS)
@pytest.mark.parametrize(
    ("slice_", "unit"), [(in_boyer_lindquist, 1.0), (in_boyer_lindquist, 1e6), (in_kerr_schild, 1e-3)]
)
def test_kerr(a, slice_, unit):
    shape = HorizonShape.of(slice_(a, unit))
    around = shape.circumferences
    for found, expected in (
        (around.equatorial, 4.0 * np.pi),
        (around.longest, 4.0 * np.pi),
        (around.polar, polar(a)),
    ):
        assert abs(found.value / unit - expected) <= min(found.error / unit, 1e-12)
    expected, R = moments(a), np.sqrt(2.0 * (1.0 + np.sqrt(1.0 - a * a)))
    n = np.arange(9)
    scale = np.sqrt(4.0 * np.pi / (2 * n + 1))
    for found, exact, power in (
        (shape.multipoles.shape, expected.real, 0),
        (shape.multipoles.rotation, expected.imag, 0),
        (shape.multipoles.mass, scale * R**n / (2.0 * np.pi) * expected.real, n + 1),
        (shape.multipoles.spin, scale * R ** (n + 1) / (4.0 * np.pi) * expected.imag, n + 1),
    ):
        difference = np.abs(values(found) - exact * unit**power)
        assert np.all(difference <= errors(found))
        assert np.all(difference <= 1e-12 * (2.0 * unit) ** power)
    assert shape.multipoles.mass[0].value == pytest.approx(unit, rel=1e-13)


def test_named_moments():
    multipoles = HorizonShape.of(KerrNewmanHorizon(2.0, 1.2).data()).multipoles
    assert multipoles.shape[0].value == pytest.approx(np.sqrt(np.pi), abs=1e-13)  # Gauss and Bonnet
    assert abs(multipoles.shape[1].value) < 1e-13  # no dipole
    assert multipoles.mass[0].value == pytest.approx(2.0, abs=1e-13)
    assert multipoles.spin[1].value == pytest.approx(2.4, abs=1e-13)
    down = HorizonShape.of(KerrNewmanHorizon(2.0, -1.2).data()).multipoles
    assert down.spin[1].value == pytest.approx(-2.4, abs=1e-13)


def test_charge_is_in_the_mass():
    multipoles = HorizonShape.of(KerrNewmanHorizon(1.0, 0.5, 0.6).data()).multipoles
    assert multipoles.mass[0].value == pytest.approx(1.0, abs=1e-13)


def test_rotation_of_a_charged_horizon_without_its_spin():
    data = replace(KerrNewmanHorizon(1.0, 0.5, 0.6).data(), angular_momentum=None)
    multipoles = HorizonShape.of(data).multipoles
    assert multipoles.mass is None
    assert multipoles.rotation[0].value == pytest.approx(0.0, abs=1e-13)
    assert multipoles.spin[1].value == pytest.approx(find_spin(data).J.value, rel=1e-12)


def test_no_square_of_a_mass_underflows():
    mass = HorizonShape.of(KerrNewmanHorizon(1e-100, 5e-101).data()).multipoles.mass[0]
    assert mass.value == pytest.approx(1e-100, rel=1e-12)
    assert 0.0 < mass.error < 1e-110


def test_beyond_the_limit_of_embedding_too():
    report = unembedded_report(KerrNewmanHorizon(1.0, 0.95).data(), NotEmbedded("beyond the limit", ATTEMPT))
    assert (report["message"], report["hindrance"]) == ("beyond the limit", "K < 0 at a pole")
    assert report["space"] == {"name": "euclidean", "curvature": 0.0}
    assert report["circumferences"]["equatorial"] == pytest.approx(4.0 * np.pi, abs=1e-12)
    assert report["multipoles"]["J"][1] == pytest.approx(0.95, abs=1e-12)
    text = energy_table(report)
    assert "circumferences about (0, 0, 1): equatorial 12.56637061435" in text
    assert re.search(r", J_1 0\.950* \+- ", text)


def test_of_horizons_only():
    report = unembedded_report(KerrNewmanSphere(3.0).data(), NotEmbedded("no reason", ATTEMPT))
    assert "multipoles" not in report
    assert shape_lines({"name": "a sphere"}) == []


def test_without_the_spin_there_are_the_moments_of_the_shape():
    multipoles = HorizonShape.of(SurfaceData(KerrNewmanHorizon(1.0, 0.6), marginal=True)).multipoles
    assert multipoles.rotation is multipoles.mass is multipoles.spin is None
    assert np.abs(values(multipoles.shape) - moments(0.6).real).max() < 1e-12
    known = SurfaceData(KerrNewmanHorizon(1.0, 0.6), angular_momentum=0.6, marginal=True)
    assert HorizonShape.of(known).multipoles.mass[0].value == pytest.approx(1.0, abs=1e-13)


def pear(theta):
    """rho and the derivatives of rho and z of a surface of revolution."""
    r, slope = 1.0 + 0.3 * np.cos(theta), -0.3 * np.sin(theta)
    return (
        r * np.sin(theta),
        slope * np.sin(theta) + r * np.cos(theta),
        slope * np.cos(theta) - r * np.sin(theta),
    )


def test_the_longest_circle_is_not_the_one_that_halves_the_area():
    def components(theta, phi):
        rho, rho_theta, z_theta = pear(theta)
        return rho_theta**2 + z_theta**2, 0.0, rho**2

    metric = AngleMetric(components)
    found = Circumferences.of(metric, InvariantCoordinate.about(metric))
    x, weights = np.polynomial.legendre.leggauss(100)
    theta = 0.5 * np.pi * (1.0 + x)
    _, rho_theta, z_theta = pear(theta)
    assert found.polar.value == pytest.approx(np.pi * weights @ np.hypot(rho_theta, z_theta), abs=1e-11)
    longest = 2.0 * np.pi * pear(np.linspace(0.5, 2.5, 2_000_001))[0].max()
    assert found.longest.value == pytest.approx(longest, abs=1e-11)
    assert found.equatorial.value < longest - 1e-4
    assert found.polar_bounds == (found.polar.value, found.polar.value)


def test_circles_that_are_all_equally_long():
    def components(theta, phi):  # rho^2 = 1 - cos^64 theta, which is 1 to rounding about the equator
        c, s = np.cos(theta), np.sin(theta)
        squared = s**2 * sum(c ** (2 * i) for i in range(32))
        steepness = 32.0 * np.abs(c) ** 63 * s / np.sqrt(np.maximum(squared, 1e-300))
        return steepness**2 + 4.0 * s**2, 0.0, squared

    metric = AngleMetric(components)
    found = Circumferences.of(metric, InvariantCoordinate.about(metric))
    assert abs(found.longest.value - 2.0 * np.pi) <= found.longest.error


TILTED = (0.3, -0.5, 0.4)


def test_tilted():
    geometry, a = KerrSchild(1.0, TILTED), float(np.linalg.norm(TILTED))
    surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    data = surface.data(geometry, marginal=True)
    shape = HorizonShape.of(data, find_spin(data))
    assert shape.circumferences.equatorial.value == pytest.approx(4.0 * np.pi, abs=1e-12)
    assert shape.circumferences.polar.value == pytest.approx(polar(a), abs=1e-12)
    expected = moments(a)
    assert np.abs(values(shape.multipoles.shape) - expected.real).max() < 1e-12
    assert np.abs(values(shape.multipoles.rotation) - expected.imag).max() < 1e-12
    assert shape.multipoles.spin[1].value == pytest.approx(a, abs=1e-12)


BOOST, VELOCITY = np.array([0.96, 0.0, 0.28]), 0.3
SPHEROID = np.diag([1.0, 1.0, 1.4])
PERIMETER = 4.0 * 1.4 * ellipe(1.0 - 1.0 / 1.4**2)


def boosted(w):
    """Directions as they are seen by an observer in motion, and the differential: a conformal map."""
    s, g = np.sqrt(1.0 - VELOCITY**2), 1.0 / (1.0 + VELOCITY * (w @ BOOST))
    along = np.outer(BOOST, BOOST)
    u = g[:, None] * (s * w + ((1.0 - s) * (w @ BOOST) + VELOCITY)[:, None] * BOOST)
    matrix = s * np.eye(3) + (1.0 - s) * along - VELOCITY * u[:, :, None] * BOOST
    return u, g[:, None, None] * matrix


def test_a_symmetry_that_is_none_of_the_directions():
    """A spheroid, seen so that its poles are not opposite to one another."""
    upright = InvariantCoordinate.about(PulledBack(lambda u: np.broadcast_to(SPHEROID, (len(u), 3, 3))))
    metric = PulledBack(lambda w: SPHEROID @ boosted(w)[1])
    transform = SphereTransform(Harmonics(48, 48), 49, 98)
    potential = upright.derivatives(boosted(transform.u)[0])[0][:, None]
    zeta = InvariantCoordinate.of_potential(transform.analysis(potential)[:, 0], transform.harmonics, 1e-14)
    north, south = zeta.poles
    assert np.abs(boosted(np.stack([north, south]))[0] - [[0, 0, 1], [0, 0, -1]]).max() < 1e-11
    assert north @ south > -0.9
    found = Circumferences.of(metric, zeta)
    assert found.equatorial.value == pytest.approx(2.0 * np.pi, abs=1e-12)
    assert found.longest.value == pytest.approx(2.0 * np.pi, abs=1e-11)
    assert found.polar.value == pytest.approx(PERIMETER, abs=1e-11)
    assert found.polar_bounds == pytest.approx((PERIMETER, PERIMETER), abs=1e-9)


def test_without_a_symmetry_meridians_are_bounded():
    axes = np.array([1.3, 1.0, 1.1])
    metric = PulledBack(lambda u: np.broadcast_to(np.diag(axes), (len(u), 3, 3)))
    shape = HorizonShape.of(SurfaceData(metric, marginal=True))
    assert shape.axis == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)
    assert shape_lines(shape.report)[0].startswith("circumferences about (1, 0, 0): equatorial")
    found = shape.circumferences
    short, long = (4.0 * 1.3 * ellipe(1.0 - (b / 1.3) ** 2) for b in (1.0, 1.1))
    low, high = found.polar_bounds
    assert (low, high) == pytest.approx((short, long), rel=1e-7)  # both are meridians
    assert low <= short < long <= high
    assert short < found.polar.value < long
    assert found.equatorial.value == pytest.approx(4.4 * ellipe(1.0 - (1.0 / 1.1) ** 2), rel=1e-9)
    assert "without symmetry" in shape_lines(HorizonShape.of(SurfaceData(metric, marginal=True)).report)[0]


def test_uncertain_lengths_make_uncertain_numbers():
    data = KerrNewmanHorizon(1.0, 0.7).data()
    zeta = InvariantCoordinate.about(data.metric)
    rough = SurfaceData(data.metric, normal_momentum=data.normal_momentum, marginal=True, relative_error=1e-5)
    assert Circumferences.of(data.metric, zeta, Uncertainty(1e-4, 1e-5)).polar.error > 1e-4
    assert errors(Multipoles.of(rough, zeta).mass).min() > 1e-5


def test_a_surface_that_is_a_little_off_the_horizon():
    geometry = KerrSchild(1.0, (0.0, 0.0, 0.6))
    spheroid = geometry.spheroid(geometry.horizon)
    surface = StarSurface.from_radius(lambda u: spheroid(u) * (1.001 + 0.001 * u[:, 2] ** 2))
    data = horizon_data(surface_points(surface), geometry, marginal=True)[0]
    assert 0.0 < data.displacement < 0.02
    shape = HorizonShape.of(data, find_spin(data))
    for found, exact in (
        (shape.circumferences.equatorial, 4.0 * np.pi),
        (shape.circumferences.polar, polar(0.6)),
    ):
        assert 1e-3 < abs(found.value - exact) <= found.error
    assert np.all(
        np.abs(values(shape.multipoles.shape) - moments(0.6).real) <= errors(shape.multipoles.shape)
    )
    assert abs(shape.multipoles.spin[1].value - 0.6) <= shape.multipoles.spin[1].error < 1e-9


def surface_points(surface):
    u = fibonacci_directions(800)
    return CoordinateShape.star_shaped(surface.points(u), "points", np.zeros(3))


@pytest.mark.parametrize(("a", "n"), [(0.3, 8), (0.6, 12), (0.9, 12), (0.9, 16)])
def test_errors_hold_on_coarse_grids(a, n):
    grid = GridMetric.sampled(KerrNewmanHorizon(1.0, a), n, 2 * n)
    shape = HorizonShape.of(SurfaceData(grid, marginal=True))
    around = shape.circumferences
    assert 0.0 < abs(around.equatorial.value - 4.0 * np.pi) <= around.equatorial.error < 1e-3
    assert abs(around.polar.value - polar(a)) <= around.polar.error < 1e-4
    assert np.all(np.abs(values(shape.multipoles.shape) - moments(a).real) <= errors(shape.multipoles.shape))
