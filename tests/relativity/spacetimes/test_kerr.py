"""Surfaces of Kerr-Newman: reference values, first variation of area, the 3-metric, limits, refusals."""

# ruff: noqa: N802, N806 (R and its derivatives as the module writes them)

from dataclasses import dataclass, replace
from functools import cache
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gallery import Ergosphere, KerrHorizon
from isoembed.gallery.kerr import Radius
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.spin import find_spin
from isoembed.relativity.spacetimes.kerr import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrNewmanSurface,
    embeddability,
    smarr_limit,
)
from isoembed.smooth.two_metric import area_density

LIMIT = sqrt(3.0) / 2.0
HORIZONS = [
    (0.0, 50.265482457436691, 25.132741228718345, 0.25),
    (0.3, 49.107848325860670, 24.844371648046456, 0.232320023615),
    (0.5, 46.898333599528960, 24.300446945608874, 0.196152422706),
    (0.6, 45.238934211693022, 23.898597646410372, 0.166666666666),
    (0.8, 40.212385965949353, 22.730557214111993, 0.0625),
    (LIMIT, 37.699111843077518, 22.188336555767362, 0.0),
]
SPHERES = [  # a, r, area, IMC, int k dA, Brown-York energy
    (0.5, 3.0, 115.87029226967145, 38.161871704273792, 44.972940695271297, 1.2474088054291813),
    (0.5, 6.0, 454.82974804253785, 75.601540033348012, 123.57495410571815, 1.0992882037637871),
    (0.8, 3.0, 120.12242026143980, 38.873468325120506, 47.093684610105368, 1.2196541460073282),
]
ERGOSPHERES = [  # epsilon, area, IMC, K at the pole, K < 0 in degrees
    (0.05, 67.980900896869771, 32.349200545475379, 286.3510234064, (9.40287709, 47.9139623)),
    (0.1, 68.778813182860604, 31.525077013543588, 122.8712172021, (10.8632013, 46.6146419)),
    (0.5, 84.498458825124000, 33.021720529589184, 8.965476258578, (14.2636586, 37.2289803)),
    (1.0, 114.17680840964232, 38.104671061790772, 1.683794416331, (15.6993280, 27.0284151)),
    (1.5, 151.33152478382481, 43.789269646631185, 0.496791179461, None),
]
POLES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
ZOO = [
    KerrNewmanHorizon(1.0, 0.8),
    KerrNewmanHorizon(2.0, 1.9, 0.4),
    KerrNewmanSphere(1.9, 1.0, -0.9),
    KerrNewmanSphere(5.0, 2.0, 1.1, 0.9),
    KerrNewmanErgosphere(0.1),
    KerrNewmanErgosphere(0.5, 2.0, 1.2, -1.1),
]


def directions(theta, phi=0.4):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


@cache
def rule():
    return gauss_rule(400, 1)


def integral(surface, f):
    """Of f over the surface, by Gauss's rule."""
    u, weight = rule()
    return weight * area_density(surface.tensor(u)) @ f(u)


@pytest.mark.parametrize(("a", "area", "imc", "at_pole"), HORIZONS)
def test_horizons(a, area, imc, at_pole):
    horizon = KerrNewmanHorizon(spin=a)
    assert horizon.area == pytest.approx(area, rel=4e-15)
    assert horizon.gaussian_curvature(POLES) == pytest.approx([at_pole] * 2, abs=1e-12)
    profile = horizon.profile()
    assert profile.embeds and profile.negative_curvature == ()
    assert profile.area == pytest.approx(area, rel=4e-15)
    assert profile.integrated_mean_curvature == pytest.approx(imc, rel=1e-14)
    assert np.all(horizon.mean_curvature(directions(np.linspace(0.0, pi, 30))) == 0.0)


def test_dunajski_and_tod():
    energy = KerrNewmanHorizon(spin=LIMIT).profile().integrated_mean_curvature / (4.0 * pi)
    assert energy == pytest.approx(1.7656917209184877, rel=1e-14)


@pytest.mark.parametrize(("a", "r", "area", "imc", "int_k", "energy"), SPHERES)
def test_brown_york(a, r, area, imc, int_k, energy):
    surface = KerrNewmanSphere(r, spin=a)
    assert surface.area == pytest.approx(area, rel=4e-15)
    profile = surface.profile()
    assert profile.integrated_mean_curvature == pytest.approx(imc, rel=1e-14)
    k = integral(surface, surface.data().mean_curvature)
    assert k == pytest.approx(int_k, rel=1e-14)
    assert (2.0 * profile.integrated_mean_curvature - k) / (8.0 * pi) == pytest.approx(energy, rel=2e-14)


@pytest.mark.parametrize(("epsilon", "area", "imc", "at_pole", "negative"), ERGOSPHERES)
def test_ergospheres(epsilon, area, imc, at_pole, negative):
    surface = KerrNewmanErgosphere(epsilon)
    assert surface.area == pytest.approx(area, rel=4e-15)
    assert surface.gaussian_curvature(POLES) == pytest.approx([at_pole] * 2, rel=1e-12)
    profile = surface.profile()
    assert profile.embeds
    assert profile.area == pytest.approx(area, rel=4e-15)
    assert profile.integrated_mean_curvature == pytest.approx(imc, rel=3e-14)
    found = np.degrees(profile.negative_curvature)
    if negative is None:
        assert found.size == 0
    else:
        mirror = (180.0 - negative[1], 180.0 - negative[0])
        np.testing.assert_allclose(found, [negative, mirror], atol=1e-7)


def test_ergospheres_are_convex_from_the_known_epsilon_on():
    known = 1.2977301304924984
    assert KerrNewmanErgosphere(known - 1e-6).profile().negative_curvature
    assert not KerrNewmanErgosphere(known + 1e-6).profile().negative_curvature


@pytest.mark.parametrize(
    ("ours", "gallery"),
    [
        (KerrNewmanHorizon(2.0, 1.1, 0.9), KerrHorizon(2.0, 1.1, 0.9)),
        (KerrNewmanErgosphere(0.3, 2.0, 1.7), Ergosphere(0.3, 2.0, 1.7)),
    ],
)
def test_the_gallery_has_the_same_surfaces(ours, gallery):
    u = np.concatenate([POLES, directions(np.linspace(0.0, pi, 40))])
    np.testing.assert_allclose(area_density(ours.tensor(u)), gallery.area_density(u), rtol=1e-14)
    np.testing.assert_allclose(ours.gaussian_curvature(u), gallery.gaussian_curvature(u), rtol=1e-11)
    np.testing.assert_allclose(ours.profile().points(u), gallery.point(u), atol=1e-13)


@pytest.mark.parametrize("surface", ZOO, ids=str)
def test_gauss_and_bonnet(surface):
    assert integral(surface, surface.gaussian_curvature) == pytest.approx(4.0 * pi, rel=2e-11)
    u, weight = rule()
    assert weight @ area_density(surface.tensor(u)) == pytest.approx(surface.area, rel=1e-13)


def test_the_horizon_has_smarrs_curvature_in_the_general_formula_too():
    u = directions(np.linspace(0.0, pi, 31))
    for a, Q in ((0.5, 0.0), (0.99, 0.0), (0.6, 0.7)):
        horizon = KerrNewmanHorizon(1.0, a, Q)
        general = KerrNewmanSurface.gaussian_curvature(horizon, u)
        np.testing.assert_allclose(horizon.gaussian_curvature(u), general, atol=1e-13)


@dataclass(frozen=True)
class Bumped(KerrNewmanSurface):
    """Another surface with its radius moved by t sin(theta)^(2 n), in units of the mass."""

    base: KerrNewmanSurface
    n: int
    t: float

    def __post_init__(self):
        for name in ("mass", "spin", "charge"):
            object.__setattr__(self, name, getattr(self.base, name))

    def _R(self, s):
        R, R_s, R_ss, _ = self.base._R(s)
        n, (a, Q) = self.n, self._ratios
        R = R + self.t * s**n
        R_s = R_s + (self.t * n * s ** (n - 1) if n > 0 else 0.0)
        R_ss = R_ss + (self.t * n * (n - 1) * s ** (n - 2) if n > 1 else 0.0)
        return Radius(R, R_s, R_ss, R**2 - 2.0 * R + a * a + Q * Q)


@pytest.mark.parametrize("n", [0, 1, 2, 5])
@pytest.mark.parametrize("surface", ZOO[2:], ids=str)
def test_k_is_the_first_variation_of_area(surface, n):
    # d(area) = int k (normal displacement) dA; moving r by dR displaces by sqrt(Sigma / (Delta + R_th^2)) dR.
    h = 2e-3
    A = {i: Bumped(surface, n, i * h).area for i in (-3, -2, -1, 1, 2, 3)}
    differences = (45.0 * (A[1] - A[-1]) - 9.0 * (A[2] - A[-2]) + (A[3] - A[-3])) / (60.0 * h)

    def moved(u):
        s = u[:, 0] ** 2 + u[:, 1] ** 2
        R, R_s, _, Delta = surface._R(s)
        Sigma = R**2 + surface._ratios[0] ** 2 * (1.0 - s)
        lapse = np.sqrt(Sigma / (Delta + 4.0 * s * (1.0 - s) * R_s**2))
        return surface.mean_curvature(u) * lapse * s**n * surface.mass

    assert integral(surface, moved) == pytest.approx(differences, rel=2e-8)


def divergence_of_the_normal(surface, theta):
    """From the 3-metric as it is printed, by differences of sixth order in r and theta."""
    M, a, Q = surface.mass, surface.spin, surface.charge

    def radius(t):
        return float(surface._R(np.array([np.sin(t) ** 2])).R[0]) * M

    def slope(t):
        return differences(radius, t, 2e-3)

    def normal(r, t):
        Sigma, Delta = r * r + (a * np.cos(t)) ** 2, r * r - 2.0 * M * r + a * a + Q * Q
        g_phph = (r * r + a * a + (2.0 * M * r - Q * Q) * (a * np.sin(t)) ** 2 / Sigma) * np.sin(t) ** 2
        density = np.sqrt(Sigma / Delta * Sigma * g_phph)
        n_r, n_t = Delta / Sigma, -slope(t) / Sigma
        length = np.sqrt(Sigma / Delta * n_r**2 + Sigma * n_t**2)
        return density * n_r / length, density * n_t / length, density

    def differences(f, x, h):
        d1, d2, d3 = (f(x + i * h) - f(x - i * h) for i in (1, 2, 3))
        return (45.0 * d1 - 9.0 * d2 + d3) / (60.0 * h)

    r = radius(theta)
    total = differences(lambda x: normal(x, theta)[0], r, 1e-3 * M) + differences(
        lambda t: normal(r, t)[1], theta, 1e-3
    )
    return total / normal(r, theta)[2]


@pytest.mark.parametrize("surface", ZOO[2:], ids=str)
def test_k_is_the_divergence_of_the_normal(surface):
    theta = np.array([0.3, 0.7, 1.2, pi / 2.0, 2.5])
    expected = [divergence_of_the_normal(surface, t) for t in theta]
    np.testing.assert_allclose(surface.mean_curvature(directions(theta)), expected, rtol=1e-7)


@pytest.mark.parametrize("surface", ZOO, ids=str)
def test_the_poles_are_points_like_others(surface):
    near = directions(np.array([1e-7, 1e-5, pi - 1e-5]))
    for f in (surface.mean_curvature, surface.gaussian_curvature):
        np.testing.assert_allclose(f(near), f(POLES)[0], rtol=1e-6)
    q = surface.tensor(POLES)
    np.testing.assert_allclose(q[0], np.diag([q[0, 0, 0]] * 2 + [0.0]), atol=1e-14 * q[0, 0, 0])
    np.testing.assert_allclose(surface.tensor(near)[:2], [q[0]] * 2, atol=1e-3 * q[0, 0, 0])


@pytest.mark.parametrize(("r", "Q"), [(2.0, 0.0), (3.0, 0.0), (10.0, 0.0), (100.0, 0.0), (2.0, 0.8)])
def test_schwarzschild_and_reissner_nordstrom(r, Q):
    surface = KerrNewmanSphere(r, 1.0, 0.0, Q)
    f = 1.0 - 2.0 / r + Q * Q / (r * r)
    u = directions(np.linspace(0.0, pi, 9))
    np.testing.assert_allclose(surface.mean_curvature(u), 2.0 / r * sqrt(f), rtol=1e-14)
    np.testing.assert_allclose(surface.gaussian_curvature(u), 1.0 / r**2, rtol=1e-13)
    k = integral(surface, surface.mean_curvature)
    energy = (2.0 * surface.profile().integrated_mean_curvature - k) / (8.0 * pi)
    assert energy == pytest.approx(r * (1.0 - sqrt(f)), rel=1e-12)


def test_far_away_the_energy_is_the_mass():
    # E = M + M^2 / (2 r) + O(r^-2)
    for a in (0.5, 0.9):
        surface = KerrNewmanSphere(1e4, spin=a)
        k = integral(surface, surface.mean_curvature)
        energy = (2.0 * surface.profile().integrated_mean_curvature - k) / (8.0 * pi)
        assert energy == pytest.approx(1.0 + 0.5e-4, abs=1e-7)


def twist(surface):
    """The integral of K_ij n^i phi^j / (8 pi) over r = const, from the frame dragging omega."""
    M, a, Q, r = surface.mass, surface.spin, surface.charge, surface.r

    def omega(x, t):  # x complex: the imaginary part of a tiny step is a derivative
        Delta = x * x - 2.0 * M * x + a * a + Q * Q
        return a * (2.0 * M * x - Q * Q) / ((x * x + a * a) ** 2 - Delta * (a * np.sin(t)) ** 2)

    def integrand(t):
        u = directions(np.array([t]), 0.0)
        P = surface.tensor(u)[0, 1, 1]
        return -0.125 * np.sin(t) ** 3 * P**2 * omega(r + 1e-30j, t).imag / 1e-30

    return quad(integrand, 0.0, pi, epsabs=1e-12)[0]


def test_angular_momentum():
    for r in (1.9, 3.0, 20.0):
        surface = KerrNewmanSphere(r, 1.0, 0.9)
        assert twist(surface) == pytest.approx(surface.angular_momentum, rel=1e-12)
    charged = KerrNewmanSphere(4.0, 1.0, 0.6, 0.5)
    assert charged.angular_momentum is None and charged.data().angular_momentum is None
    assert charged.data().charge == 0.5
    # Why: it depends on the surface, and only far away it is a M.
    values = [twist(replace(charged, r=r)) for r in (2.0, 4.0, 1e4)]
    assert values[0] < 0.98 * values[1] < 0.96 * values[2]
    assert values[2] == pytest.approx(0.6, rel=1e-4)


@pytest.mark.parametrize("r", [1.7, 3.0, 50.0])
@pytest.mark.parametrize("a", [0.6, -0.6])
def test_angular_momentum_in_its_parts(r, a):
    surface = KerrNewmanSphere(2.0 * r, 2.0, 2.0 * a, 1.2)
    part = surface.electromagnetic_angular_momentum
    assert twist(surface) + part == pytest.approx(4.0 * a, rel=1e-11)
    assert surface.data().electromagnetic_angular_momentum == abs(part)


def test_angular_momentum_of_a_charged_ergosphere_in_its_parts():
    data = KerrNewmanErgosphere(0.5, 1.0, 0.6, 0.5).data()
    part = data.electromagnetic_angular_momentum
    assert find_spin(data).J.value + part == pytest.approx(0.6, abs=1e-11)
    assert KerrNewmanErgosphere(0.5, 1.0, 0.6).data().electromagnetic_angular_momentum == 0.0


@given(a=st.floats(-0.99, 0.99), Q=st.floats(-0.99, 0.99), mass=st.floats(0.1, 10.0))
def test_the_mass_formula_of_christodoulou_and_ruffini(a, Q, mass):
    shrink = max(1.0, float(np.hypot(a, Q)) / 0.999)
    data = KerrNewmanHorizon(mass, a / shrink * mass, Q / shrink * mass).data()
    u, weight = gauss_rule(60, 1)
    irreducible = sqrt(weight @ area_density(data.metric.tensor(u)) / (16.0 * pi))
    total = (irreducible + data.charge**2 / (4.0 * irreducible)) ** 2
    total += (data.angular_momentum / (2.0 * irreducible)) ** 2
    assert sqrt(total) == pytest.approx(mass, rel=1e-9)


def test_the_data_of_a_surface():
    surface = KerrNewmanSphere(4.0, 2.0, 1.0)
    data = surface.data()
    u = directions(np.linspace(0.0, pi, 5))
    assert data.metric is surface and data.momentum is None
    assert np.array_equal(data.mean_curvature(u), surface.mean_curvature(u))
    assert (data.angular_momentum, data.charge) == (2.0, 0.0)
    assert data.name == "Kerr-Newman surface r = const of mass 2, spin 1, charge 0"


@pytest.mark.parametrize("scale", [1e-150, 1e-20, 1e12, 1e150])
def test_no_mass_is_special(scale):
    u = directions(np.linspace(0.0, pi, 7))
    for one, other in (
        (KerrNewmanHorizon(1.0, 0.9), KerrNewmanHorizon(scale, 0.9 * scale)),
        (
            KerrNewmanSphere(3.0, 1.0, 0.5, 0.3),
            KerrNewmanSphere(3.0 * scale, scale, 0.5 * scale, 0.3 * scale),
        ),
        (KerrNewmanErgosphere(0.2), KerrNewmanErgosphere(0.2, scale, 0.975 * scale)),
    ):
        np.testing.assert_allclose(other.tensor(u) / scale / scale, one.tensor(u), rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(other.mean_curvature(u) * scale, one.mean_curvature(u), rtol=1e-11)
        K = other.gaussian_curvature(u) * scale * scale
        np.testing.assert_allclose(K, one.gaussian_curvature(u), rtol=1e-11)
        assert other.area / scale / scale == pytest.approx(one.area, rel=1e-13)
        np.testing.assert_allclose(other.profile().obstruction, one.profile().obstruction, atol=1e-11)


def test_the_limit_is_smarrs():
    assert smarr_limit() == pytest.approx(LIMIT, rel=1e-15)
    assert smarr_limit(2.0) == pytest.approx(2.0 * LIMIT, rel=1e-15)
    for charge in (0.3, 0.7, 0.81):
        a = smarr_limit(1.0, charge)
        assert KerrNewmanHorizon(1.0, a, charge).radius == pytest.approx(sqrt(3.0) * a, rel=1e-14)
        assert KerrNewmanHorizon(1.0, a * (1.0 - 1e-6), charge).profile().embeds
        assert not KerrNewmanHorizon(1.0, a * (1.0 + 1e-6), charge).profile().embeds
    extreme = smarr_limit(1.0, 0.9)  # every one embeds
    assert extreme == pytest.approx(sqrt(1.0 - 0.81), rel=1e-15)
    assert KerrNewmanHorizon(1.0, extreme, 0.9).profile().embeds


@pytest.mark.parametrize("a", [0.87, 0.9, 0.95, 1.0])
def test_beyond_the_limit_a_band_embeds(a):
    horizon = KerrNewmanHorizon(spin=a)
    profile = horizon.profile()
    ((_, north), (south, _)) = profile.obstruction
    # h_phph = (r_+^2 + a^2)^2 s / Sigma, h_thth = Sigma.
    r2 = horizon.radius**2

    def excess(theta):
        Sigma = r2 + (a * np.cos(theta)) ** 2
        rho_theta = (r2 + a * a) * np.cos(theta) * (r2 + a * a) / Sigma**1.5
        return Sigma - rho_theta**2

    assert excess(north - 1e-9) < 0.0 < excess(north + 1e-9)
    assert south == pytest.approx(pi - north, abs=1e-11)
    # K < 0 on a smaller cap; its edge is in closed form.
    ((_, flat), _) = profile.negative_curvature
    assert np.cos(flat) ** 2 == pytest.approx(r2 / (3.0 * a * a), rel=1e-11)
    assert flat < north
    (band,) = profile.bands
    assert (band.start, band.stop) == (north, south)
    half, _ = quad(
        lambda x: 2.0 * x * np.sqrt(max(0.0, excess(north + x * x))),
        0.0,
        sqrt(pi / 2.0 - north),
        epsabs=1e-13,
    )
    assert band.height == pytest.approx(2.0 * half, rel=1e-10)
    vertices, faces = band.mesh(32)
    assert np.ptp(vertices[:, 2]) == pytest.approx(band.height, rel=1e-12)
    assert len(faces) == 2 * (len(vertices) - 32)


def test_what_is_said_about_the_embedding():
    assert embeddability(KerrNewmanHorizon(spin=0.5)).startswith(
        "Kerr-Newman horizon with r_+ = 1.8660254 >= sqrt(3) a = 0.866025404"
        " (it embeds up to spin 0.866025404; Smarr 1973): the metric is that of a surface of revolution"
    )
    sentence = embeddability(KerrNewmanHorizon(spin=0.9))
    assert "r_+ = 1.43588989 < sqrt(3) a = 1.55884573" in sentence
    assert (
        "no surface of revolution has this metric for theta < 0.561403 and theta > 2.58019: there" in sentence
    )
    assert "K < 0 for theta < 0.399839 and theta > 2.74175" in sentence
    assert "0.561403 < theta < 2.58019 embeds, 84.6509 % of the area" in sentence
    assert embeddability(KerrNewmanErgosphere()).startswith("distorted ergosphere: the metric is that of")
    near = embeddability(KerrNewmanSphere(1.45, spin=0.9))
    assert near.startswith("Kerr-Newman surface r = const: no surface of revolution")
    with pytest.raises(
        InvalidMetric, match=r"no surface of revolution has this metric for theta < 0\.561403"
    ):
        _ = KerrNewmanHorizon(spin=0.9).profile().integrated_mean_curvature


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: KerrNewmanHorizon(mass=0.0), "Kerr-Newman horizon: mass must be positive, not 0.0"),
        (lambda: KerrNewmanHorizon(spin=float("nan")), "Kerr-Newman horizon: spin must be finite, not nan"),
        (
            lambda: KerrNewmanHorizon(spin=(0, 0, 0.5)),
            "spin must be one number, about the z-axis, not \\(0, 0",
        ),
        (
            lambda: KerrNewmanHorizon(2.0, 1.6, 1.6),
            r"spin\^2 \+ charge\^2 must be at most mass\^2 for a horizon to exist, not 1.28 mass\^2",
        ),
        (lambda: KerrNewmanSphere(1.5), r"r must be at least r_\+ = 2, not 1.5"),
        (lambda: KerrNewmanSphere(3.1, 2.0, 1.6, 0.2), r"r must be at least r_\+ = 3.18\d+, not 3.1"),
        (
            lambda: KerrNewmanErgosphere(0.0),
            "distorted ergosphere: epsilon must be between 1e-6 and 1e6, not 0.0",
        ),
        (
            lambda: KerrNewmanErgosphere(spin=1.0),
            r"the root of spin\^2 \+ charge\^2 must be at most 0.9999 mass, not 1 mass",
        ),
        (lambda: smarr_limit(1.0, 1.1), r"for a horizon to exist, not 1\.21 mass\^2"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        make()
