"""Surfaces in slices: spheres, horizons and Kerr's constant-r surfaces in closed form, and fits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.kerr_slices import BoyerLindquist, KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import (
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable, CallableGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import angle_frame, area_density

ORIGIN = (0.0, 0.0, 0.0)
SPINS = [(0, 0, 0.6), (0, -0.6 * np.sin(0.4), 0.6 * np.cos(0.4)), (0.3, 0.5, -0.7)]


def directions(n=40):
    """Unit vectors, the poles and the axes among them."""
    u = np.concatenate([np.random.default_rng(5).normal(size=(n, 3)), np.eye(3), -np.eye(3)])
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def integral(surface, geometry, f=lambda u: 1.0, n=32):
    u, weights = gauss_rule(n, 2 * n)
    return float(np.sum(weights * area_density(surface.metric(geometry).tensor(u)) * f(u)))


def ellipsoid(u):
    return (u**2 @ [1.0, 1 / 1.21, 1 / 1.44]) ** -0.5


def bumpy(u):
    return 3.0 + 0.2 * u[:, 0] * u[:, 1] - 0.3 * u[:, 2] ** 3 + 0.1 * u[:, 1]


class TestMeanCurvature:
    def test_of_schwarzschilds_spheres(self):
        M, R = 1.3, 3.0
        r = R * (1 + M / (2 * R)) ** 2
        k = StarSurface.sphere(ORIGIN, R).mean_curvature(IsotropicSchwarzschild(M), directions())
        np.testing.assert_allclose(k, 2 * np.sqrt(1 - 2 * M / r) / r, rtol=1e-14)

    @pytest.mark.parametrize("r", [1.0, 2.6, 7.0])
    def test_of_falling_observers_spheres(self, r):
        M, u = 1.3, directions()
        surface, hole = StarSurface.sphere(ORIGIN, r), PainleveGullstrand(M)
        k, p = surface.mean_curvature(hole, u), surface.momentum(hole, u)
        np.testing.assert_allclose(k, 2 / r, rtol=1e-14)
        np.testing.assert_allclose(p, 2 * np.sqrt(2 * M / r) / r, rtol=1e-14)
        np.testing.assert_allclose(k**2 - p**2, 4 / r**2 * (1 - 2 * M / r), atol=1e-13)
        np.testing.assert_allclose(surface.expansion(hole, u), k - p, atol=1e-15)

    def test_of_an_ellipsoid_off_its_center_in_flat_space(self):
        shift, axes = np.array([0.1, -0.2, 0.15]), np.array([1.0, 1.1, 1.2])

        def radius(u):  # the positive root of |(shift + r u) / axes| = 1
            a, b, c = (u**2) @ axes**-2, u @ (shift / axes**2), shift @ (shift / axes**2) - 1
            return (-b + np.sqrt(b**2 - a * c)) / a

        surface, u = StarSurface.from_radius(radius, shift), directions()
        gradient = 2 * surface.points(u) / axes**2
        length = np.linalg.norm(gradient, axis=1)
        hessian = 2 / axes**2
        k = hessian.sum() / length - (gradient**2 @ hessian) / length**3
        np.testing.assert_allclose(surface.mean_curvature(PainleveGullstrand(1.0), u), k, rtol=1e-11)

    @pytest.mark.parametrize(
        "geometry", [KerrSchild(1.0, SPINS[2]), BrillLindquist([1.0, 0.4], [(0.3, 0, 0), (0, 0.2, -1)])]
    )
    def test_is_the_first_variation_of_area(self, geometry):
        # dA = int k <n, dX> dA for dX = f(u) u, f being one harmonic after the other
        surface, step = StarSurface.from_radius(bumpy), 1e-3
        harmonics = surface.harmonics
        u, weights = gauss_rule(32, 64)
        x = surface.points(u)
        k = surface.mean_curvature(geometry, u)
        dA = weights * area_density(surface.metric(geometry).tensor(u))
        # <n, u> dA = sqrt(det gamma) r^2 dOmega, whatever the slope
        volume = weights * np.sqrt(np.linalg.det(geometry.metric(x))) * surface.radius(u) ** 2
        assert dA.sum() > 4 * np.pi
        for i in (0, 1, 3, 7):

            def area(amount, i=i):
                moved = surface.coefficients.copy()
                moved[i] += amount
                return integral(StarSurface(ORIGIN, harmonics, moved), geometry)

            change = (8 * (area(step) - area(-step)) - (area(2 * step) - area(-2 * step))) / (12 * step)
            expected = np.sum(k * harmonics.values(u)[:, i] * volume)
            assert change == pytest.approx(expected, abs=1e-10 * dA.sum())

    @given(seed=st.integers(0, 10))
    def test_turns_with_the_surface_and_the_spin(self, seed):
        Q = Rotation.random(random_state=seed).as_matrix()
        u, spin = directions(5), np.array(SPINS[2])
        surface = StarSurface.from_radius(bumpy)
        turned = StarSurface.from_radius(lambda u: bumpy(u @ Q))
        hole, other = KerrSchild(1.0, spin), KerrSchild(1.0, Q @ spin)
        for quantity in ("mean_curvature", "momentum"):
            one = getattr(surface, quantity)(hole, u)
            np.testing.assert_allclose(getattr(turned, quantity)(other, u @ Q.T), one, atol=1e-12)
        assert turned.angular_momentum(other, Q[:, 2]) == pytest.approx(
            surface.angular_momentum(hole, (0, 0, 1)), abs=1e-13
        )

    @settings(max_examples=10)
    @given(exponent=st.integers(-60, 60))
    def test_scales(self, exponent):
        unit, u = 10.0**exponent, directions(3)
        surface = StarSurface.from_radius(bumpy)
        scaled = StarSurface.from_radius(lambda u: unit * bumpy(u))
        spin = np.array(SPINS[1])
        hole, other = KerrSchild(1.0, spin), KerrSchild(unit, unit * spin)
        np.testing.assert_allclose(
            unit * scaled.mean_curvature(other, u), surface.mean_curvature(hole, u), rtol=1e-11
        )
        np.testing.assert_allclose(unit * scaled.momentum(other, u), surface.momentum(hole, u), rtol=1e-11)
        J = surface.angular_momentum(hole, spin)
        assert scaled.angular_momentum(other, spin) / unit / unit == pytest.approx(J, rel=1e-12)


class TestKerr:
    @pytest.mark.parametrize("spin", [*SPINS, (0, 0, 0.95)])
    def test_horizon_in_kerr_schild_coordinates(self, spin):
        M = 1.0
        hole = KerrSchild(M, spin)
        horizon = StarSurface.from_radius(hole.spheroid(hole.horizon))
        np.testing.assert_allclose(horizon.expansion(hole, directions()), 0.0, atol=2e-12)
        assert integral(horizon, hole) == pytest.approx(8 * np.pi * M * hole.horizon, rel=1e-13)
        assert horizon.angular_momentum(hole, spin) == pytest.approx(M * np.linalg.norm(spin), rel=1e-13)

    def test_angular_momentum_is_that_of_the_spin_on_any_surface_around_it(self):
        hole = KerrSchild(1.0, SPINS[1])
        surface = StarSurface.from_radius(bumpy)
        assert surface.angular_momentum(hole, SPINS[1]) == pytest.approx(0.6, rel=1e-12)
        assert surface.angular_momentum(hole, -np.array(SPINS[1])) == pytest.approx(-0.6, rel=1e-12)

    def test_angular_momentum_is_about_the_center(self):
        hole, c = KerrSchild(1.0, SPINS[1]), np.array([0.5, 1.0, -2.0])
        moved = AnalyticCallable(lambda x: hole.metric(x - c), lambda x: hole.extrinsic_curvature(x - c))
        assert StarSurface.from_radius(bumpy, c).angular_momentum(moved, SPINS[1]) == pytest.approx(
            0.6, rel=1e-12
        )

    @pytest.mark.parametrize(
        ("a", "r", "area", "total"),  # findings of a second code, in extended precision
        [
            (0.5, 3.0, 115.87029226967145, 44.972940695271297),
            (0.5, 6.0, 454.82974804253785, 123.57495410571815),
            (0.8, 3.0, 120.12242026143980, 47.093684610105368),
        ],
    )
    def test_surfaces_of_constant_r(self, a, r, area, total):
        hole, sphere = BoyerLindquist(1.0, (0, 0, a)), StarSurface.sphere(ORIGIN, r)
        assert integral(sphere, hole) == pytest.approx(area, rel=1e-13)
        k = integral(sphere, hole, lambda u: sphere.mean_curvature(hole, u))
        assert k == pytest.approx(total, rel=1e-13)
        np.testing.assert_allclose(sphere.momentum(hole, directions()), 0.0, atol=1e-15)
        assert sphere.angular_momentum(hole, (0, 0, 2)) == pytest.approx(a, rel=1e-13)

    @pytest.mark.parametrize("spin", SPINS[:2])
    def test_two_slicings_agree_on_the_surfaces_that_they_share(self, spin):
        # Both times differ by a function of r: r = const is one surface of spacetime, and |H| is the same.
        r, a = 2.5, np.array(spin)
        schild, lindquist = KerrSchild(1.0, spin), BoyerLindquist(1.0, spin)
        spheroid, sphere = StarSurface.from_radius(schild.spheroid(r)), StarSurface.sphere(ORIGIN, r)
        assert integral(spheroid, schild) == pytest.approx(integral(sphere, lindquist), rel=1e-13)
        u = directions()
        axis, x = a / np.linalg.norm(a), spheroid.points(u)
        cos = x @ axis / r  # of the Boyer-Lindquist theta
        flat = x - np.outer(x @ axis, axis)
        side = np.linalg.norm(flat, axis=1, keepdims=True)
        angle = np.cross(axis, [0.3, 0.4, 0.5])
        flat = np.where(side > 1e-8, flat, angle)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        v = np.outer(cos, axis) + np.sqrt(np.maximum(1 - cos**2, 0))[:, None] * flat
        k, p = spheroid.mean_curvature(schild, u), spheroid.momentum(schild, u)
        np.testing.assert_allclose(k**2 - p**2, sphere.mean_curvature(lindquist, v) ** 2, rtol=1e-11)


class TestDerivatives:
    @pytest.mark.parametrize(("degree", "order"), [(0, 0), (1, 1), (9, 0), (9, 3), (40, 40)])
    def test_are_those_of_the_harmonics(self, degree, order):
        harmonics, u = Harmonics(degree, order), directions()
        c = np.random.default_rng(1).normal(size=harmonics.size) / (1 + harmonics.labels[0]) ** 4
        c[0] = 10.0
        surface = StarSurface(ORIGIN, harmonics, c)
        e = np.stack(angle_frame(u), axis=1)
        _, slope, hessian = harmonics.derivatives(u, c)
        values, first = harmonics.along(u, e)
        np.testing.assert_allclose(surface.radius(u), values @ c, rtol=1e-13)
        np.testing.assert_allclose(np.einsum("nai,ni->na", e, slope), first @ c, atol=1e-12)
        second = harmonics.second_along(u, e, c[:, None])[..., 0]
        np.testing.assert_allclose(e @ hessian @ e.transpose(0, 2, 1), second, atol=1e-11)
        for normal in (slope, hessian):
            np.testing.assert_allclose(np.einsum("ni,n...i->n...", u, normal), 0.0, atol=1e-12)

    def test_lists_of_directions(self):
        surface, hole = StarSurface.from_radius(bumpy), KerrSchild(1.0, SPINS[2])
        u = directions(3)
        for f in (surface.metric(hole).tensor, lambda v: surface.mean_curvature(hole, v), surface.points):
            np.testing.assert_array_equal(f(u.tolist()), f(u))

    @pytest.mark.parametrize("u", [np.array([0, 0, 1.0]), [0, 0, 1.0], np.ones((2, 2)), "z", [[1, 2], [3]]])
    def test_refusals(self, u):
        surface, hole = StarSurface.from_radius(bumpy), KerrSchild(1.0, SPINS[2])
        data = surface.data(hole)
        for f in (surface.radius, surface.points, data.metric.tensor, data.mean_curvature, data.momentum):
            with pytest.raises(InvalidParameter, match=r"directions must be unit vectors \(n, 3\), not an"):
                f(u)


class TestBrillLindquist:
    def test_total_mass_far_away(self):
        holes = BrillLindquist([1.0, 0.5], [(0, 0, 1), (0, 0, -2)])  # at the center of mass
        errors = []
        for R in (100.0, 200.0, 400.0):
            sphere = StarSurface.sphere(ORIGIN, R)
            area = integral(sphere, holes)
            k2 = integral(sphere, holes, lambda u, s=sphere: s.mean_curvature(holes, u) ** 2)
            errors.append(np.sqrt(area / (16 * np.pi)) * (1 - k2 / (16 * np.pi)) - 1.5)
        assert abs(errors[-1]) < 1e-5
        assert np.all(np.log2(np.abs(errors[:-1]) / np.abs(errors[1:])) > 0.9)

    def test_a_far_companion_scales_a_hole(self):
        # psi = (1 + m_2 / (2 d)) + m_1 / (2 r) up to the tide, that is r / d of the companion's part
        errors = []
        for d in (50.0, 100.0, 200.0):
            holes = BrillLindquist([1.0, 2.0], [ORIGIN, (0, 0, d)])
            c = 1 + 1 / d
            throat = StarSurface.sphere(ORIGIN, 0.5 / c)
            errors.append(np.abs(throat.expansion(holes, directions())).max())
            assert integral(throat, holes) == pytest.approx(16 * np.pi * c**2, rel=0.2 / d)
        assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 1.9)


class TestFromRadius:
    def test_ends_where_the_harmonics_do(self):
        surface = StarSurface.from_radius(bumpy)
        assert (surface.harmonics.degree, surface.harmonics.order) == (3, 2)
        assert surface.misfit < 1e-14
        u = directions()
        np.testing.assert_allclose(surface.radius(u), bumpy(u), rtol=1e-14)
        np.testing.assert_allclose(surface.points(u), u * bumpy(u)[:, None], rtol=1e-13, atol=1e-14)

    def test_many_harmonics(self):
        surface, u = StarSurface.from_radius(lambda u: ellipsoid(u) ** 8, (1, 2, 3)), directions()
        assert 20 < surface.harmonics.degree < 60
        np.testing.assert_allclose(surface.radius(u), ellipsoid(u) ** 8, rtol=1e-13)

    @pytest.mark.parametrize("radius", [2.0, np.ones((8, 16)), [1.0, 2.0]])
    def test_of_a_number_or_an_array(self, radius):
        with pytest.raises(InvalidParameter, match=r"not a function of unit vectors u .*for from_points"):
            StarSurface.from_radius(radius)

    def test_rotation_symmetry_is_seen(self):
        hole = KerrSchild(1.0, (0, 0, 0.9))
        assert StarSurface.from_radius(hole.spheroid(hole.horizon)).harmonics.order == 0

    @pytest.mark.parametrize(("spin", "most"), [(0.975, 1e-13), (0.985, 1e-11), (0.995, 1e-7)])
    def test_high_degrees_are_taken_for_what_they_are(self, spin, most):
        def radius(u):
            return 2.5 + np.sqrt(1 - (spin * u[:, 2]) ** 2)

        surface, u = StarSurface.from_radius(radius), directions(200)
        error = np.abs(surface.radius(u) - radius(u)).max()
        assert error < most
        assert error < 200 * surface.misfit

    @pytest.mark.parametrize("noise", [1e-14, 1e-10, 1e-7])
    def test_noise_is_not_fitted(self, noise):
        def radius(u):
            return bumpy(u) + noise * np.random.default_rng(len(u)).normal(size=len(u))

        surface, u = StarSurface.from_radius(radius), directions()
        assert surface.harmonics.degree <= 16
        assert surface.misfit == pytest.approx(noise, rel=0.5)
        np.testing.assert_allclose(surface.radius(u), bumpy(u), atol=4 * noise)
        flat = PainleveGullstrand(1.0)
        assert surface.data(flat).relative_error == pytest.approx(surface.misfit / 3.0, rel=0.1)
        with pytest.raises(
            InvalidParameter, match=r"those of degree 128 still contribute .* the error is \S+e-0[56]; fit"
        ):
            StarSurface.from_radius(lambda u: bumpy(u) + 1e-5 / noise * (radius(u) - bumpy(u)))

    def test_by_angles(self):
        surface = StarSurface.from_angles(
            lambda theta, phi: 3 + 0.4 * np.sin(theta) ** 2 * np.cos(2 * phi), (1, 0, 0)
        )
        u = directions()
        np.testing.assert_allclose(surface.radius(u), 3 + 0.4 * (u[:, 0] ** 2 - u[:, 1] ** 2), rtol=1e-14)
        assert StarSurface.from_angles(lambda theta, phi: 2.0).harmonics.size == 1

    def test_differential_is_that_of_differences(self):
        surface, u = StarSurface.from_radius(bumpy), directions()
        v = np.cross(u, [0.3, -0.5, 0.8])
        forward, back = (
            surface.points((w := u + s * v) / np.linalg.norm(w, axis=1, keepdims=True)) for s in (1e-5, -1e-5)
        )
        change = np.einsum("nij,nj->ni", surface.differential(u), v)
        np.testing.assert_allclose(change, (forward - back) / 2e-5, atol=1e-8)

    @pytest.mark.parametrize(
        ("make", "sentence"),
        [
            (
                lambda: StarSurface.from_radius(lambda u: u[:, 2] + 0.5),
                r"the radius is -\S+ in the direction \(",
            ),
            (lambda: StarSurface.from_radius(lambda u: u), r"the radius has the shape \(200, 3\) for 200"),
            (
                lambda: StarSurface.from_radius(lambda u: np.nan * u[:, 0]),
                "the radius is nan in the direction",
            ),
            (
                lambda: StarSurface.from_radius(lambda u: 1 + 0.1 * np.abs(u[:, 0])),
                r"not smooth enough for harmonics: those of degree 128 still contribute \S+e-06",
            ),
            (lambda: StarSurface.sphere(ORIGIN, -1.0), "the radius must be positive, not -1.0"),
            (lambda: StarSurface.sphere(ORIGIN, "big"), "the radius must be positive, not big"),
            (lambda: StarSurface.sphere("here", 1.0), "the center must be three finite numbers, not here"),
            (lambda: StarSurface.sphere((0, np.nan, 0), 1.0), "the center must be three finite numbers"),
            (
                lambda: StarSurface(ORIGIN, Harmonics(1, 1), np.ones(3)),
                r"4 harmonics require as many .* not \(3,\)",
            ),
            (
                lambda: StarSurface(ORIGIN, Harmonics(1, 0), np.array([1.0, 2.0])),
                r"the radius is -\S+ in the",
            ),
        ],
    )
    def test_refusals(self, make, sentence):
        with pytest.raises(InvalidParameter, match=sentence):
            make()


class TestFromPoints:
    @staticmethod
    def sample(m, radius=bumpy, seed=2):
        u = np.random.default_rng(seed).normal(size=(m, 3))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        return u, u * radius(u)[:, None]

    def test_exact_points(self):
        center = np.array([0.3, -0.2, 0.1])
        surface = StarSurface.from_points(self.sample(300)[1] + center, center)
        assert surface.harmonics.degree == 3
        assert surface.misfit < 1e-14
        np.testing.assert_allclose(surface.radius(directions()), bumpy(directions()), rtol=1e-13)

    def test_all_digits_of_a_horizon(self):
        hole = KerrSchild(1.0, SPINS[1])
        _, points = self.sample(2000, hole.spheroid(hole.horizon))
        fitted = StarSurface.from_points(points, ORIGIN)
        np.testing.assert_allclose(fitted.expansion(hole, directions()), 0.0, atol=1e-11)

    @pytest.mark.parametrize("seed", range(5))
    def test_noise_is_not_fitted_but_reported(self, seed):
        u, points = self.sample(3000)
        noisy = points + 1e-4 * u * np.random.default_rng(seed).normal(size=(len(u), 1))
        surface = StarSurface.from_points(noisy, ORIGIN)
        assert surface.harmonics.degree == 3
        assert surface.misfit == pytest.approx(1e-4, rel=0.05)
        error = surface.radius(directions()) - bumpy(directions())
        assert np.abs(error).max() < 5e-5

    def test_points_given_twice_do_no_harm(self):
        _, points = self.sample(300)
        twice = np.concatenate([points, points[:150], points[:20] * (1 + 1e-16)])
        surface = StarSurface.from_points(twice, ORIGIN)
        np.testing.assert_allclose(surface.radius(directions()), bumpy(directions()), rtol=1e-13)

    def test_few_points_given_often_are_few_points(self):
        _, points = self.sample(12)
        assert StarSurface.from_points(np.tile(points, (10, 1)), ORIGIN).harmonics.degree == 1

    def test_a_crowd_of_points_counts_for_its_solid_angle(self):
        crowd = np.array([0.0, 0.6, 0.8]) + 0.05 * self.sample(3000, seed=1)[1]
        crowd /= np.linalg.norm(crowd, axis=1, keepdims=True)
        points = np.concatenate([crowd * bumpy(crowd)[:, None], self.sample(100)[1]])
        surface = StarSurface.from_points(points, ORIGIN)
        np.testing.assert_allclose(surface.radius(directions()), bumpy(directions()), rtol=1e-12)

    def test_a_hole_lowers_the_degree(self):
        hole = KerrSchild(1.0, (0, 0, 0.9))
        u, points = self.sample(2000, hole.spheroid(hole.horizon))
        whole = StarSurface.from_points(points, ORIGIN)
        part = StarSurface.from_points(points[u[:, 2] > -0.8], ORIGIN)
        assert part.harmonics.degree < whole.harmonics.degree / 2
        assert part.misfit > 1e3 * whole.misfit
        exact = hole.spheroid(hole.horizon)(directions())
        assert np.abs(part.radius(directions()) - exact).max() < 100 * part.misfit

    @given(exponent=st.integers(-100, 100))
    def test_scales(self, exponent):
        _, points = self.sample(100)
        surface = StarSurface.from_points(10.0**exponent * points, ORIGIN)
        np.testing.assert_allclose(
            surface.radius(directions(3)), 10.0**exponent * bumpy(directions(3)), rtol=1e-12
        )

    @pytest.mark.parametrize(
        ("spoil", "sentence"),
        [
            (lambda x: x[:7], r"points must be an array \(m, 3\) with m >= 8, not \(7, 3\)"),
            (lambda x: x[:, :2], r"points must be an array .* not \(100, 2\)"),
            (
                lambda x: np.where(np.arange(100)[:, None] == 4, np.nan, x),
                r"point 4 is \(nan, nan, nan\): that is",
            ),
            (
                lambda x: np.where(np.arange(100)[:, None] == 4, 0.0, x),
                r"point 4 is the center \(0, 0, 0\) itself",
            ),
            (lambda x: np.abs(x), "do not surround the center: a half-space contains none"),
            (lambda x: x * [1, 1, 0], "do not surround the center: a half-space contains none"),
        ],
    )
    def test_refusals(self, spoil, sentence):
        with pytest.raises(InvalidParameter, match=sentence):
            StarSurface.from_points(spoil(self.sample(100)[1]), ORIGIN)


class TestData:
    def test_of_a_slice_that_moves(self):
        hole, surface, u = KerrSchild(1.0, SPINS[0]), StarSurface.from_radius(bumpy), directions()
        data = surface.data(hole, axis=(0, 0, 1))
        np.testing.assert_array_equal(data.metric.tensor(u), surface.metric(hole).tensor(u))
        np.testing.assert_array_equal(data.mean_curvature(u), surface.mean_curvature(hole, u))
        np.testing.assert_array_equal(data.momentum(u), surface.momentum(hole, u))
        assert data.angular_momentum == pytest.approx(0.6, rel=1e-12)
        plain = surface.data(hole)
        assert plain.angular_momentum is None
        assert not plain.marginal
        assert plain.relative_error < 1e-15
        horizon = surface.data(hole, marginal=True, name="mine")
        assert horizon.marginal
        assert horizon.name == "mine"

    def test_misfit_and_geometry_make_the_error(self):
        surface = StarSurface(ORIGIN, Harmonics(0, 0), [3.0 * np.sqrt(4 * np.pi)], misfit=0.06)
        hole = IsotropicSchwarzschild(1.0)
        assert surface.data(hole).relative_error == pytest.approx(0.02, rel=1e-14)
        user, x = CallableGeometry(hole.metric, 12.0), surface.points(directions())
        exact = replace(surface, misfit=0.0)
        k = exact.data(user).mean_curvature
        true = np.abs(k(directions()) - exact.mean_curvature(hole, directions())).max()
        assert true < k.error.pointwise < 100.0 * true
        assert (
            exact.data(user).relative_error
            < 1e-15
            < 1e-12
            < np.abs(user.gradient(x) - hole.gradient(x)).max()
        )

    def test_of_a_time_symmetric_slice(self):
        data = StarSurface.sphere(ORIGIN, 2.0).data(IsotropicSchwarzschild(1.0), axis=(0, 0, 1))
        assert data.momentum is None
        assert data.angular_momentum == 0.0

    def test_differences_are_almost_as_good(self):
        hole, surface, u = KerrSchild(1.0, SPINS[1]), StarSurface.from_radius(bumpy), directions()
        user = CallableGeometry(hole.metric, 2.0, hole.extrinsic_curvature)
        np.testing.assert_allclose(surface.expansion(user, u), surface.expansion(hole, u), atol=1e-11)

    @pytest.mark.parametrize(
        ("axis", "sentence"),
        [
            (ORIGIN, "the axis must not be zero"),
            ("z", "the axis must be three finite numbers, not z"),
            (2, "the axis must be three finite numbers, not 2"),
            ([[1, 2], 3, 4], "the axis must be three finite numbers"),
        ],
    )
    def test_axes_that_are_none(self, axis, sentence):
        with pytest.raises(InvalidParameter, match=sentence):
            StarSurface.sphere(ORIGIN, 2.0).data(PainleveGullstrand(1.0), axis=axis)

    def test_refusals(self):
        sphere, flat = StarSurface.sphere(ORIGIN, 2.0), PainleveGullstrand(1.0)

        def nan(x):
            return np.full((len(x), 3, 3), np.nan)

        def away(x):
            return np.where(np.linalg.norm(x, axis=1)[:, None, None] < 1.999, np.nan, flat.metric(x))

        for geometry, what in (
            (CallableGeometry(nan, 1.0), "the 3-metric at .* is not positive definite"),
            (CallableGeometry(away, 1.0), "the gradient of the 3-metric at .* is not finite"),
            (CallableGeometry(flat.metric, 1.0, nan), "the extrinsic curvature at .* is not finite"),
        ):
            with pytest.raises(InvalidMetric, match=what):
                sphere.data(geometry)
        u = np.array([[0, 0, 1.0]])
        with pytest.raises(InvalidMetric, match=r"the 3-metric at \(0, 0, 2\) is not positive definite"):
            sphere.metric(CallableGeometry(nan, 1.0)).tensor(u)
        with pytest.raises(InvalidMetric, match=r"the extrinsic curvature at \(0, 0, 2\) is not finite"):
            sphere.momentum(CallableGeometry(flat.metric, 1.0, nan), u)
