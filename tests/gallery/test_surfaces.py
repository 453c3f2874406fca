"""The closed-form surfaces against published digits, closed forms, finite differences and each other."""

# ruff: noqa: N803, N806 (the symbols of the paper)

from dataclasses import FrozenInstanceError, fields
from functools import cache
from itertools import product
from math import gamma, pi, sqrt

import numpy as np
import pytest
from scipy.special import lpmv

from isoembed.gallery import (
    SURFACES,
    Bean,
    BentTube,
    CassiniPeanut,
    Drum,
    Ellipsoid,
    Ergosphere,
    HarmonicSurface,
    KerrHorizon,
    Sphere,
    Superellipsoid,
)
from isoembed.meshing.directions import directions_of

HORIZON_LIMIT = sqrt(3.0) / 2.0

# Area, volume and int H dA from long-double quadrature of fundamental forms in polar angles that were
# derived by computer algebra, Carlson's forms and Minkowski's formulas.
REFERENCE = [
    (Sphere(), 12.56637061435917295, 4.188790204786390984, 12.56637061435917295),
    (Ellipsoid((3, 2, 1)), 48.88214630258205969, 25.13274122871834590, 26.40485738798982204),
    (Ellipsoid((1, 1, 2)), 21.47843532788373680, 8.377580409572781969, 17.34376540669010325),
    (Ellipsoid((10, 1, 1)), 99.15103054409205990, 41.88790204786390984, 64.72202505854832063),
    (Ellipsoid((5, 4, 3)), 199.4550593619437405, 251.3274122871834590, 50.89568667984106662),
    (Ellipsoid((2, 2, 1)), 34.68753081338020650, 16.75516081914556393, 21.47843532788373680),
    (Ellipsoid((5, 5, 1)), 171.7804219217564969, 104.7197551196597746, 50.19251018313683124),
    (Drum(), 27.74931709548283918, 12.31247836955389531, 19.45945082749739226),
    (Superellipsoid(), 17.58718906909784673, 6.481987351786382022, 15.16424924358832289),
    (CassiniPeanut(0.9, 1.0), 8.822777970637986755, 1.949984913809087139, 11.97965329513894205),
    (CassiniPeanut(0.8, 1.2), 15.34938005885299677, 5.332208155617788054, 14.24430712402155104),
    (HarmonicSurface(2, 2, 0.35), 14.130715096784953836, 4.5992916448554569935, 13.67104719063483377),
    (HarmonicSurface(3, 3, 0.3), 14.236555357945604524, 4.4472984002817794423, 13.890228809871295669),
    (HarmonicSurface(4, 3, 0.12), 13.035435684408012244, 4.2323642611135147053, 12.981200560822677596),
    (HarmonicSurface(4, 0, -0.25, 2.0), 53.90662940184194763, 34.199037976490686597, 26.44354630957478319),
    (Bean(), 12.437255638121585168, 3.2840115205525305018, 14.329418815341900977),
    (BentTube(), 7.552478833611201152, 1.3995795271742529837, 11.957121612079717981),
    (BentTube((2.0, 0.8, 0.5), 1.0), 13.503020049401827072, 3.3510321638291127415, 15.174590634998122161),
    (KerrHorizon(spin=0.0), 50.265482457436691, 33.510321638291127, 25.132741228718345),
    (KerrHorizon(spin=0.3), 49.107848325860670, 32.348488235046034, 24.844371648046456),
    (KerrHorizon(spin=0.5), 46.898333599528960, 30.103897179572039, 24.300446945608874),
    (KerrHorizon(spin=0.6), 45.238934211693022, 28.388689083036905, 23.898597646410372),
    (KerrHorizon(spin=0.8), 40.212385965949353, 22.936243396793503, 22.730557214111993),
    (KerrHorizon(spin=HORIZON_LIMIT), 37.699111843077518, 19.908411553932757, 22.188336555767362),
    (Ergosphere(0.05), 67.980900896869771, 47.637787842375815, 32.349200545475379),
    (Ergosphere(0.1), 68.778813182860604, 49.408390783266009, 31.525077013543588),
    (Ergosphere(0.5), 84.498458825124000, 70.631449995250541, 33.021720529589184),
    (Ergosphere(1.0), 114.17680840964232, 112.42594269670234, 38.104671061790772),
    (Ergosphere(1.5), 151.33152478382481, 172.52429440211143, 43.789269646631185),
]
SURFACE_ZOO = [row[0] for row in REFERENCE] + [
    Superellipsoid((3.0, 1.0, 2.0), 6.0),
    Drum((1.0, 3.0, 2.0)),
    KerrHorizon(mass=2.0, spin=-1.0, charge=0.7),
    Ergosphere(0.02, mass=3.0, spin=2.5),
    HarmonicSurface(5, 2, 0.2, 3.0),
    HarmonicSurface(1, 1, 0.5),
    Bean((3.0, 1.0, 2.0), -1.5),
]


def sphere_points(n=300, seed=1):
    u = np.random.default_rng(seed).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1)[:, None]


def polar(theta, phi=0.3):
    theta = np.atleast_1d(theta)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


@cache
def sphere_quadrature(n=120):
    """Gauss in theta on each hemisphere, trapezoid in phi: not the rule that the package uses."""
    x, w = np.polynomial.legendre.leggauss(n)
    theta = np.concatenate([(x + 1.0) * pi / 4.0, (x + 3.0) * pi / 4.0])
    weight = np.tile(w * pi / 4.0, 2) * np.sin(theta)
    phi = 2.0 * pi * np.arange(2 * n) / (2 * n)
    u = np.concatenate([polar(theta, p) for p in phi])
    return u, np.tile(weight, 2 * n) * pi / n


@pytest.mark.parametrize(("surface", "area", "volume", "imc"), REFERENCE, ids=lambda x: str(x)[:40])
def test_integrals_are_the_reference_values(surface, area, volume, imc):
    assert surface.area == pytest.approx(area, rel=3e-14)
    assert surface.volume == pytest.approx(volume, rel=3e-14)
    assert surface.integrated_mean_curvature == pytest.approx(imc, rel=3e-14)


@pytest.mark.parametrize("surface", SURFACE_ZOO, ids=str)
def test_directions_name_their_points(surface):
    u = sphere_points(100)
    assert np.abs(directions_of(surface, surface.point(u)) - u).max() < 1e-9


def test_a_point_beside_the_surface_has_no_direction():
    with pytest.raises(ValueError, match=r"point 1, \[0\.0, 0\.0, 3\.0\], is not on Ellipsoid"):
        directions_of(Ellipsoid((3.0, 2.0, 1.0)), [[3.0, 0, 0], [0, 0, 3.0]])


@pytest.mark.parametrize("surface", SURFACE_ZOO, ids=str)
def test_gauss_bonnet_and_minkowski(surface):
    u, weight = sphere_quadrature()
    dA = weight * surface.area_density(u)
    K, H = surface.gaussian_curvature(u), surface.mean_curvature(u)
    support = np.einsum("ij,ij->i", surface.point(u), surface.normal(u))
    assert dA @ K == pytest.approx(4.0 * pi, rel=1e-9)
    assert dA @ (H * support) == pytest.approx(surface.area, rel=1e-9)
    assert dA @ (K * support) == pytest.approx(surface.integrated_mean_curvature, rel=1e-9)
    assert dA @ support / 3.0 == pytest.approx(surface.volume, rel=1e-9)


@pytest.mark.parametrize("surface", SURFACE_ZOO, ids=str)
def test_curvatures_and_normals_are_those_of_the_points(surface):
    # The fundamental forms from central differences of point() in an orthonormal frame at u.
    u = sphere_points(60)
    a = np.cross(u, np.roll(u, 1, axis=1))
    a /= np.linalg.norm(a, axis=1)[:, None]
    b = np.cross(u, a)
    h = 1e-3

    def x(i, j):
        return surface.point(u + h * (i * a + j * b))

    dot = lambda p, q: np.einsum("ij,ij->i", p, q)  # noqa: E731
    x_a, x_b = (
        (8 * (x(i, j) - x(-i, -j)) - x(2 * i, 2 * j) + x(-2 * i, -2 * j)) / (12 * h)
        for i, j in ((1, 0), (0, 1))
    )
    x_aa = (16 * (x(1, 0) + x(-1, 0)) - x(2, 0) - x(-2, 0) - 30 * x(0, 0)) / (12 * h**2)
    x_bb = (16 * (x(0, 1) + x(0, -1)) - x(0, 2) - x(0, -2) - 30 * x(0, 0)) / (12 * h**2)
    mixed = lambda k: (x(k, k) - x(k, -k) - x(-k, k) + x(-k, -k)) / (4 * (k * h) ** 2)  # noqa: E731
    x_ab = (4 * mixed(1) - mixed(2)) / 3
    cross = np.cross(x_a, x_b)
    jacobian = np.linalg.norm(cross, axis=1)
    n = cross / jacobian[:, None]
    E, F, G = dot(x_a, x_a), dot(x_a, x_b), dot(x_b, x_b)
    e, f, g = -dot(x_aa, n), -dot(x_ab, n), -dot(x_bb, n)
    scale = 1.0 / np.abs(surface.mean_curvature(u)).max()
    np.testing.assert_allclose(surface.normal(u), n, atol=1e-7)
    np.testing.assert_allclose(surface.area_density(u), jacobian, rtol=1e-7)
    K = (e * g - f**2) / (E * G - F**2)
    H = (e * G - 2 * f * F + g * E) / (2 * (E * G - F**2))
    np.testing.assert_allclose(surface.gaussian_curvature(u) * scale**2, K * scale**2, atol=2e-5)
    np.testing.assert_allclose(surface.mean_curvature(u) * scale, H * scale, atol=2e-5)


@pytest.mark.parametrize(
    ("surface", "powers"),
    [
        (Ellipsoid((3, 2, 1)), (2, 2, 2)),
        (Drum(), (2, 2, 4)),
        (Superellipsoid((1, 2, 3), 3.5), (3.5, 3.5, 3.5)),
        (Sphere(2.0), (2, 2, 2)),
    ],
    ids=str,
)
def test_points_satisfy_the_implicit_equation(surface, powers):
    x = surface.point(sphere_points())
    g = (np.abs(x / np.array(surface.axes)) ** np.array(powers)).sum(axis=1)
    np.testing.assert_allclose(g, 1.0, rtol=1e-14)


def test_points_of_the_peanut_have_the_product_of_distances():
    x = CassiniPeanut(0.9, 1.1).point(sphere_points())
    foci = np.array([[0, 0, 0.9], [0, 0, -0.9]])
    distances = np.linalg.norm(x[:, None] - foci, axis=2)
    np.testing.assert_allclose(distances.prod(axis=1), 1.1**2, rtol=1e-13)


def test_superellipsoid_volume_in_closed_form():
    for p in (2.0, 2.5, 4.0, 10.0):
        closed = 8.0 * 6.0 * gamma(1 + 1 / p) ** 3 / gamma(1 + 3 / p)
        assert Superellipsoid((1, 2, 3), p).volume == pytest.approx(closed, rel=1e-12)


def test_superellipsoid_of_power_two_is_the_ellipsoid():
    a, b = Superellipsoid((3, 2, 1), 2.0), Ellipsoid((3, 2, 1))
    assert (a.area, a.volume) == pytest.approx((b.area, b.volume), rel=1e-13)
    assert a.integrated_mean_curvature == pytest.approx(b.integrated_mean_curvature, rel=1e-13)


@pytest.mark.parametrize(
    ("surface", "radius"),
    [
        (HarmonicSurface(2, 2, 0.35), lambda x, y, z: 1 + 0.35 * (x**2 - y**2)),
        (HarmonicSurface(3, 3, 0.3), lambda x, y, z: 1 + 0.3 * (x**3 - 3 * x * y**2)),
        (
            HarmonicSurface(4, 3, 0.375 * 3 * sqrt(3) / 16),
            lambda x, y, z: 1 + 0.375 * z * (x**3 - 3 * x * y**2),
        ),
        (HarmonicSurface(2, 0, -0.4, 2.0), lambda x, y, z: 2 - 0.4 * (3 * z**2 - 1)),
    ],
    ids=["2, 2", "3, 3", "4, 3", "2, 0"],
)
def test_harmonic_surfaces_have_the_radius_of_the_harmonic_polynomial(surface, radius):
    u = sphere_points()
    np.testing.assert_allclose(surface.point(u), radius(*u.T)[:, None] * u, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(
    ("degree", "order"), [(1, 0), (2, 1), (5, 0), (6, 2), (9, 8), (16, 0), (16, 5), (16, 16)]
)
def test_harmonics_are_the_associated_legendre_functions_with_maximum_one(degree, order):
    theta, phi = np.linspace(0, pi, 20_001), 0.0 if order == 0 else pi / order
    Y = 2.0 * (np.linalg.norm(HarmonicSurface(degree, order, 0.5).point(polar(theta, phi)), axis=1) - 1)
    P = lpmv(order, degree, np.cos(theta))
    np.testing.assert_allclose(np.abs(Y), np.abs(P) / np.abs(P).max(), atol=1e-6)
    assert np.abs(Y).max() == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize(("degree", "order"), [(2, 2), (3, 1), (4, 3), (7, 0)])
def test_small_harmonics_curve_the_sphere_by_their_eigenvalue(degree, order):
    # r = 1 + A Y has H = 1 + (l - 1)(l + 2) A Y / 2 and K = 1 + (l - 1)(l + 2) A Y to first order in A.
    u = sphere_points()
    errors = []
    for A in (1e-3, 5e-4):
        surface = HarmonicSurface(degree, order, A)
        first = (degree - 1) * (degree + 2) * (np.linalg.norm(surface.point(u), axis=1) - 1)
        of_H = np.abs(surface.mean_curvature(u) - 1 - first / 2).max()
        of_K = np.abs(surface.gaussian_curvature(u) - 1 - first).max()
        errors.append([of_H, of_K])
    assert np.all(np.array(errors[0]) > 0)
    np.testing.assert_allclose(np.divide(*errors), 4, rtol=0.05)


@pytest.mark.parametrize(("degree", "order"), [(2, 2), (3, 3), (5, 2)])
def test_harmonics_are_symmetric_under_turns_about_z(degree, order):
    def turned(u, angle):
        c, s = np.cos(angle), np.sin(angle)
        return u @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

    u, one, other = sphere_points(), *(HarmonicSurface(degree, order, A) for A in (0.2, -0.2))
    full, half = 2 * pi / order, pi / order
    np.testing.assert_allclose(one.point(turned(u, full)), turned(one.point(u), full), atol=1e-14)
    np.testing.assert_allclose(other.point(turned(u, half)), turned(one.point(u), half), atol=1e-14)


def test_volumes_of_the_bent_and_the_bumpy():
    for axes in ((1.6, 0.7, 0.7), (2.0, 0.8, 0.5)):  # shears and windings keep the volume
        ellipsoid = pytest.approx(Ellipsoid(axes).volume, rel=1e-14)
        assert Bean(axes, 0.9).volume == ellipsoid
        assert BentTube(axes, 1.0).volume == ellipsoid
    # int r^3 / 3 over the sphere, with the averages of Y^2 and Y^3.
    assert HarmonicSurface(2, 2, 0.5).volume == pytest.approx(
        4 * pi / 3 * (1 + 3 * 0.5**2 * 4 / 15), rel=1e-14
    )
    assert HarmonicSurface(3, 3, 0.5).volume == pytest.approx(
        4 * pi / 3 * (1 + 3 * 0.5**2 * 8 / 35), rel=1e-14
    )
    assert HarmonicSurface(2, 0, 0.5).volume == pytest.approx(
        4 * pi / 3 * (1 + 3 * 0.5**2 / 5 + 0.5**3 * 2 / 35), rel=1e-14
    )


@pytest.mark.parametrize("axes", [(3.0, 2.0, 1.0), (1.0, 1.0, 2.0), (10.0, 1.0, 1.5)])
def test_without_the_bend_it_is_the_ellipsoid(axes):
    ellipsoid, u = Ellipsoid(axes), sphere_points()
    for straight, digits in ((Bean(axes, 0.0), 1e-13), (BentTube(axes, 1e9), 1e-7)):
        np.testing.assert_allclose(straight.point(u), ellipsoid.point(u), atol=10 * digits)
        np.testing.assert_allclose(
            straight.gaussian_curvature(u), ellipsoid.gaussian_curvature(u), rtol=digits
        )
        np.testing.assert_allclose(straight.mean_curvature(u), ellipsoid.mean_curvature(u), rtol=digits)
        assert straight.area == pytest.approx(ellipsoid.area, rel=1e-13)
        assert straight.integrated_mean_curvature == pytest.approx(
            ellipsoid.integrated_mean_curvature, rel=1e-13
        )


def test_the_tube_satisfies_its_equation_around_the_circle():
    (a, b, c), R = axes, radius = (2.0, 0.8, 0.5), 1.0
    x, y, z = BentTube(axes, radius).point(sphere_points()).T
    along, out = R * np.arctan2(x, z + R), np.hypot(x, z + R) - R
    np.testing.assert_allclose((along / a) ** 2 + (y / b) ** 2 + (out / c) ** 2, 1, rtol=1e-13)


@pytest.mark.parametrize("surface", [HarmonicSurface(), Bean(), BentTube(), CassiniPeanut()], ids=str)
def test_the_bodies_that_are_not_convex_are_so_by_default(surface):
    u, weight = sphere_quadrature(60)
    K = surface.gaussian_curvature(u)
    assert (weight * surface.area_density(u))[K < 0].sum() > 0.1 * surface.area


def kerr_newman_2_metric(R, R_theta, theta, M, a, Q):
    """Eqs. (gthth)-(delta) and (twosurf) of the paper, as printed."""
    Sigma = R**2 + a**2 * np.cos(theta) ** 2
    Delta = R**2 - 2 * M * R + a**2 + Q**2
    tt = Sigma * (1 + np.divide(R_theta**2, Delta, out=np.zeros_like(R), where=R_theta != 0))
    pp = (R**2 + a**2 + (2 * M * R - Q**2) * a**2 * np.sin(theta) ** 2 / Sigma) * np.sin(theta) ** 2
    return tt, pp


@pytest.mark.parametrize(
    "surface",
    [
        KerrHorizon(spin=0.8),
        KerrHorizon(spin=HORIZON_LIMIT),
        KerrHorizon(mass=2.0, spin=1.1, charge=0.9),
        Ergosphere(0.1),
        Ergosphere(0.3, mass=2.0, spin=1.7),
        Ergosphere(1.5),
    ],
    ids=str,
)
def test_kerr_line_element_is_reproduced(surface):
    M, a, Q = surface.mass, surface.spin, getattr(surface, "charge", 0.0)
    theta = np.linspace(0.05, pi - 0.05, 101)
    if isinstance(surface, Ergosphere):  # Eq. (rtheta)
        root = np.sqrt(1 - (a / M) ** 2 * np.cos(theta) ** 2)
        R = M * (1 + root) + surface.epsilon * M
        R_theta = M * (a / M) ** 2 * np.cos(theta) * np.sin(theta) / root
    else:
        R = np.full_like(theta, M + sqrt(M**2 - a**2 - Q**2))
        R_theta = np.zeros_like(theta)
    h_tt, h_pp = kerr_newman_2_metric(R, R_theta, theta, M, a, Q)
    h = 1e-3
    along = [surface.point(polar(theta + k * h)) for k in (-2, -1, 1, 2)]
    x_theta = (along[0] - 8 * along[1] + 8 * along[2] - along[3]) / (12 * h)
    np.testing.assert_allclose((x_theta**2).sum(axis=1), h_tt, rtol=1e-7)
    x = surface.point(polar(theta))
    np.testing.assert_allclose(x[:, 0] ** 2 + x[:, 1] ** 2, h_pp, rtol=1e-13)
    density = surface.area_density(polar(theta))
    np.testing.assert_allclose(density * np.sin(theta), np.sqrt(h_tt * h_pp), rtol=1e-12)


def test_kerr_horizon_digits():
    pole = [[0.0, 0.0, 1.0]]
    for spin, height, K in [
        (0.3, 1.9302174446795959, 0.232320023615),
        (0.5, 1.7926536241661325, 0.196152422706),
        (0.8, 1.3170194730773450, 0.0625),
        (HORIZON_LIMIT, 1.0762482790146539, 0.0),
    ]:
        horizon = KerrHorizon(spin=spin)
        assert horizon.point(pole)[0] == pytest.approx([0, 0, height], rel=1e-13)
        assert horizon.gaussian_curvature(pole)[0] == pytest.approx(K, abs=1e-12)
        # The horizon's equator has circumference 4 pi M, its area is 8 pi M r_+.
        assert np.linalg.norm(horizon.point([[0.6, 0.8, 0.0]])) == pytest.approx(2.0, rel=1e-14)
        assert horizon.area == pytest.approx(8 * pi * (1 + sqrt(1 - spin**2)), rel=1e-13)


@pytest.mark.parametrize(
    ("epsilon", "K_pole", "first", "last", "K_min", "theta_min", "integral"),
    [
        (0.05, 286.3510234064, 9.40287709, 47.9139623, -0.393609, 17.118, -5.085180004),
        (0.1, 122.8712172021, 10.8632013, 46.6146419, -0.356209, 18.432, -4.152968934),
        (0.5, 8.965476258578, 14.2636586, 37.2289803, -0.133078, 20.610, -1.007440493),
        (1.0, 1.683794416331, 15.6993280, 27.0284151, -0.023165, 19.935, -0.101846681),
    ],
)
def test_negative_curvature_of_the_ergosphere(epsilon, K_pole, first, last, K_min, theta_min, integral):
    surface = Ergosphere(epsilon)
    K = lambda degrees: surface.gaussian_curvature(polar(np.radians(degrees)))  # noqa: E731
    assert K(0.0)[0] == pytest.approx(K_pole, rel=1e-10)
    assert np.all(K(np.array([first - 1e-6, last + 1e-6])) > 0)
    assert np.all(K(np.linspace(first + 1e-6, last - 1e-6, 400)) < 0)
    assert np.all(K(np.linspace(0, first - 1e-6, 400)) > 0)
    assert np.all(K(np.linspace(last + 1e-6, 90, 400)) > 0)
    assert K(theta_min)[0] == pytest.approx(K_min, abs=2e-6)
    assert np.all(K(np.array([theta_min - 0.1, theta_min + 0.1])) > K(theta_min)[0])
    x, w = np.polynomial.legendre.leggauss(80)
    theta = np.radians(first + (last - first) * (x + 1) / 2)
    band = (
        2 * pi * np.sin(theta) * surface.area_density(polar(theta)) * surface.gaussian_curvature(polar(theta))
    )
    assert 2 * (w @ band) * np.radians(last - first) / 2 == pytest.approx(integral, rel=1e-8)


def test_ergosphere_becomes_convex_at_the_known_epsilon():
    theta = np.linspace(0, pi / 2, 4001)
    least = [Ergosphere(1.2977301304924984 + d).gaussian_curvature(polar(theta)).min() for d in (-1e-4, 1e-4)]
    assert least[0] < 0 < least[1]


@pytest.mark.parametrize("surface", SURFACE_ZOO, ids=str)
def test_mirror_symmetry(surface):
    u = sphere_points(20)
    mirrors = [(1, -1)] * 3
    if isinstance(surface, Bean | BentTube):
        mirrors[2] = (1,)
    elif isinstance(surface, HarmonicSurface):  # of order 3 even in y alone, and odd in z where l - m is
        mirrors[0] = (1, -1)[: 1 + (surface.order % 2 == 0)]
        mirrors[2] = (1, -1)[: 1 + ((surface.degree - surface.order) % 2 == 0)]
    for signs in product(*mirrors):
        np.testing.assert_allclose(
            surface.point(u * signs), surface.point(u) * signs, rtol=1e-13, atol=1e-300
        )


OF_UNIT_SCALE = [
    *(Ellipsoid((3, 2, 1)), Drum(), CassiniPeanut(0.9, 1), HarmonicSurface()),
    *(Bean(), BentTube(), KerrHorizon(spin=0.8), Ergosphere(0.3)),
]
"""Each computes its integrals once."""


@pytest.mark.parametrize("scale", [1e-150, 1e-40, 1e12, 1e100])
def test_scaling_laws(scale):
    others = [
        Ellipsoid((3 * scale, 2 * scale, scale)),
        Drum((2 * scale, scale, sqrt(1.5) * scale)),
        CassiniPeanut(0.9 * scale, scale),
        HarmonicSurface(radius=scale),
        Bean((1.6 * scale, 0.7 * scale, 0.7 * scale), 0.9 * scale),
        BentTube((1.65 * scale, 0.45 * scale, 0.45 * scale), 1.5 * scale),
        KerrHorizon(scale, 0.8 * scale),
        Ergosphere(0.3, scale, 0.975 * scale),
    ]
    u = sphere_points(50)
    for one, other in zip(OF_UNIT_SCALE, others, strict=True):
        np.testing.assert_allclose(other.point(u) / scale, one.point(u), rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(other.mean_curvature(u) * scale, one.mean_curvature(u), rtol=1e-10)
        assert other.integrated_mean_curvature / scale == pytest.approx(
            one.integrated_mean_curvature, rel=1e-12
        )
        assert other.area / scale / scale == pytest.approx(one.area, rel=1e-12)


def test_displacements_are_followed_to_first_order():
    for surface in SURFACE_ZOO:
        u = np.concatenate([sphere_points(40), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]])
        x, n = surface._points(u), surface._normals(u)
        d = np.cross(n, np.roll(n, 1, axis=1) + np.array([0.3, 0.2, 0.1]))
        errors = [
            np.linalg.norm(surface._points(surface._moved(u, h * d)) - x - h * d, axis=1).max() / h
            for h in (1e-4, 5e-5)
        ]
        assert errors[0] < 0.1, surface
        assert errors[1] < 0.6 * errors[0], surface  # the error is second order


def test_registry_offers_every_surface_with_help_for_every_option():
    assert set(SURFACES) == {
        *("ellipsoid", "drum", "sphere", "superellipsoid", "cassini-peanut", "kerr-horizon", "ergosphere"),
        *("harmonic", "bean", "bent-tube"),
        *("cap", "cone", "catenoid", "enneper", "torus"),
    }
    for name, cls in SURFACES.items():
        surface = cls()
        assert surface.name == name
        for option in fields(cls):
            assert option.metadata["help"]
            assert option.type in (int, float, tuple[float, float, float])
            with pytest.raises(FrozenInstanceError):
                setattr(surface, option.name, 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ellipsoid((3, -2, 1)), r"ellipsoid: axes\[1\] must be positive, not -2.0"),
        (lambda: Ellipsoid((3, 2)), r"ellipsoid: axes must be three numbers, not \(3, 2\)"),
        (lambda: Ellipsoid(3), "ellipsoid: axes must be three numbers, not 3"),
        (lambda: Ellipsoid((3, 2, float("nan"))), r"ellipsoid: axes\[2\] must be finite, not nan"),
        (lambda: Ellipsoid((1e5, 2, 1)), "ellipsoid: axes must not differ by more than a factor 10000"),
        (lambda: Drum((0, 1, 1)), r"drum: axes\[0\] must be positive, not 0.0"),
        (lambda: Sphere(float("inf")), "sphere: radius must be finite, not inf"),
        (lambda: Sphere("wide"), "sphere: radius must be a number, not 'wide'"),
        (lambda: Superellipsoid(power=1.5), "superellipsoid: power must be between 2 and 20, not 1.5"),
        (lambda: CassiniPeanut(1.0, 1.0), "cassini-peanut: a must be less than 0.9999 b = 0.9999, not 1.0"),
        (lambda: CassiniPeanut(-1.0, 1.0), "cassini-peanut: a must be positive, not -1.0"),
        (lambda: HarmonicSurface(2.5), "harmonic: degree must be an integer, not 2.5"),
        (lambda: HarmonicSurface(0, 0), "harmonic: degree must be between 1 and 16, not 0"),
        (lambda: HarmonicSurface(2, 3), "harmonic: order must be between 0 and 2, not 3"),
        (lambda: HarmonicSurface(2, -1), "harmonic: order must be between 0 and 2, not -1"),
        (lambda: HarmonicSurface(amplitude=1), "harmonic: amplitude must be between -0.99 and 0.99, not 1.0"),
        (lambda: HarmonicSurface(radius=0), "harmonic: radius must be positive, not 0.0"),
        (lambda: Bean((1, 2)), r"bean: axes must be three numbers, not \(1, 2\)"),
        (lambda: Bean((3, 2, 1), -2e4), r"bean: \|height\| must be at most 10000, not -20000.0"),
        (lambda: BentTube((1, 1, 0)), r"bent-tube: axes\[2\] must be positive, not 0.0"),
        (lambda: BentTube((1, 1, 2), 2.0), "bent-tube: radius must be at least 2.0002, not 2.0"),
        (lambda: BentTube((4, 1, 1), 1.2), "bent-tube: radius must be at least 1.27337, not 1.2"),
        (lambda: KerrHorizon(mass=0.0), "kerr-horizon: mass must be positive, not 0.0"),
        (
            lambda: KerrHorizon(spin=0.87),
            r"\|spin\| must be at most 0.866025403784 for .* to embed .*, not 0.87",
        ),
        (lambda: KerrHorizon(mass=2, spin=-1.8), r"at most 1.73205080757 for .* to embed .*, not -1.8"),
        (lambda: KerrHorizon(spin=1.2), r"at most 0.866025403784 for a horizon to exist, not 1.2"),
        (lambda: KerrHorizon(spin=0.6, charge=0.8), "at most 0.59884394141 for the horizon to embed"),
        (lambda: KerrHorizon(spin=0.5, charge=0.9), "at most 0.435889894354 for a horizon to exist"),
        (lambda: KerrHorizon(charge=-1.1), r"\|charge\| must be at most the mass 1.0, not -1.1"),
        (lambda: Ergosphere(0.0), "ergosphere: epsilon must be positive, not 0.0"),
        (lambda: Ergosphere(1e-9), "ergosphere: epsilon must be between 1e-6 and 1e6, not 1e-09"),
        (lambda: Ergosphere(float("nan")), "ergosphere: epsilon must be finite, not nan"),
        (
            lambda: Ergosphere(spin=1.0),
            r"ergosphere: \|spin\| must be at most 0.9999 times the mass 1.0, not 1.0",
        ),
        (lambda: Sphere().point([1.0, 0.0, 0.0]), r"directions must have shape \(n, 3\), not \(3,\)"),
        (lambda: Sphere().point([[1, 0, 0], [0, 0, 0]]), "direction 1 must be a nonzero finite vector"),
    ],
)
def test_bad_parameters_are_named_in_one_sentence(make, message):
    with pytest.raises(ValueError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("charge", [0.0, 0.3, 0.7, 0.8, 0.81])
def test_the_horizon_is_flat_at_its_poles_at_the_spin_limit(charge):
    with pytest.raises(ValueError, match="at most") as caught:
        KerrHorizon(spin=0.9, charge=charge)
    limit = float(str(caught.value).split("at most ")[1].split()[0])
    K = [
        KerrHorizon(spin=f * limit, charge=charge).gaussian_curvature([[0, 0, 1]])[0]
        for f in (1 - 1e-7, 1 - 1e-4)
    ]
    assert 0 <= K[0] < 1e-5
    assert K[0] < 0.01 * K[1]
