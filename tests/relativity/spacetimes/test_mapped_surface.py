"""Surfaces that are maps of the sphere: the same numbers as star-shaped ones, and closed forms of others."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mapped_shapes
import zoo
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.schwarzschild import (
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import area_density

HOLE = KerrSchild(1.0, (0.3, 0.5, -0.6))
FLAT = AnalyticCallable(lambda x: np.eye(3) + 0.0 * x[:, :1, None])
SHIFT = np.array([5.0, 6.0, 7.0])
U = fibonacci_directions(60)
SHAPES = (mapped_shapes.banana, mapped_shapes.bowl, mapped_shapes.peanut, mapped_shapes.ellipsoid)


def bumpy(u):
    return 3.0 + 0.2 * u[:, 0] * u[:, 1] - 0.3 * u[:, 2] ** 3 + 0.1 * u[:, 1]


def turned(u):
    """A smooth map of the unit sphere onto itself."""
    v = u + 0.15 * np.stack([u[:, 1] ** 2, u[:, 2], u[:, 0] * u[:, 1]], axis=1)
    return v / np.linalg.norm(v, axis=1, keepdims=True)


class TestStarShaped:
    star = StarSurface.from_radius(bumpy, (0.1, -0.2, 0.3))
    mapped = MappedSurface.from_map(star.points, star.center)

    @pytest.mark.parametrize("quantity", ["mean_curvature", "momentum", "normal_momentum", "expansion"])
    def test_has_the_same_local_geometry(self, quantity):
        one, other = (getattr(surface, quantity)(HOLE, U) for surface in (self.star, self.mapped))
        np.testing.assert_allclose(other, one, atol=1e-12)

    def test_has_the_same_points_metric_and_angular_momentum(self):
        np.testing.assert_allclose(self.mapped.points(U), self.star.points(U), atol=1e-14)
        one, other = (surface.metric(HOLE).tensor(U) for surface in (self.star, self.mapped))
        np.testing.assert_allclose(other, one, atol=1e-12)
        for axis in np.eye(3):
            assert self.mapped.angular_momentum(HOLE, axis) == pytest.approx(
                self.star.angular_momentum(HOLE, axis), abs=1e-13
            )

    def test_has_the_same_data(self):
        one, other = self.star.data(HOLE), self.mapped.data(HOLE)
        np.testing.assert_allclose(other.torque(U), one.torque(U), atol=1e-12)
        assert other.lengths_error.pointwise < 1e-13
        assert other.mean_curvature.error.pointwise < 1e-9

    def test_does_not_change_with_its_parameters(self):
        other = MappedSurface.from_map(lambda u: self.star.points(turned(u)))
        for quantity in ("mean_curvature", "momentum"):
            expected = getattr(self.star, quantity)(HOLE, turned(U))
            np.testing.assert_allclose(getattr(other, quantity)(HOLE, U), expected, atol=1e-9)

    def test_kerrs_horizon(self):
        horizon = StarSurface.from_radius(HOLE.spheroid(HOLE.horizon))
        mapped = MappedSurface.from_map(lambda u: horizon.points(turned(u)))
        np.testing.assert_allclose(mapped.expansion(HOLE, U), 0.0, atol=1e-9)
        assert mapped.angular_momentum(HOLE, HOLE.spin) == pytest.approx(np.sqrt(0.7), rel=1e-12)
        u, weights = gauss_rule(40, 80)
        area = weights @ area_density(mapped.metric(HOLE).tensor(u))
        assert area == pytest.approx(8 * np.pi * HOLE.horizon, rel=1e-12)


class TestClosedForms:
    @pytest.mark.parametrize("shape", SHAPES)
    def test_in_flat_space(self, shape):
        surface = MappedSurface.from_map(shape)
        normals, k = mapped_shapes.differences(shape, U)
        local = surface.local_geometry(FLAT, U)
        np.testing.assert_allclose(local.normal[1], normals, atol=1e-11)
        np.testing.assert_allclose(local.mean_curvature, k, rtol=1e-7)

    @pytest.mark.parametrize("shape", SHAPES[:2])
    def test_in_a_conformally_flat_slice(self, shape):
        # k = (k_flat + 4 d_n psi / psi) / psi^2
        hole, surface = (
            BrillLindquist([1.0, 0.5], [(0, 0.2, -0.4), (0.3, 0, 5)]),
            MappedSurface.from_map(shape),
        )
        normals, flat = mapped_shapes.differences(shape, U)
        x = shape(U)
        psi, slope = 1.0, 0.0
        for mass, center in zip(hole.masses, hole.positions, strict=True):
            d = x - np.array(center)
            r = np.linalg.norm(d, axis=1)
            psi = psi + mass / (2 * r)
            slope = slope - mass / 2 * np.einsum("ni,ni->n", d, normals) / r**3
        k = (flat + 4 * slope / psi) / psi**2
        np.testing.assert_allclose(surface.mean_curvature(hole, U), k, rtol=1e-7, atol=1e-8)

    def test_momentum_of_a_sphere_off_center(self):
        surface = MappedSurface.from_map(lambda u: 2.0 * turned(u))
        p = surface.momentum(PainleveGullstrand(1.3), U)
        np.testing.assert_allclose(p, 2 * np.sqrt(2 * 1.3 / 2.0) / 2.0, rtol=1e-11)

    def test_torques_are_about_the_centroid(self):
        surface = MappedSurface.from_map(lambda u: mapped_shapes.ellipsoid(turned(u)) + SHIFT)
        np.testing.assert_allclose(surface.center, SHIFT, atol=1e-9)
        assert surface.mean_radius == pytest.approx(np.sqrt(48.88215 / (4 * np.pi)), rel=1e-6)


class TestInvariance:
    @settings(max_examples=10)
    @given(seed=st.integers(0, 5), exponent=st.integers(-60, 60))
    def test_turns_and_scales(self, seed, exponent):
        Q, unit = Rotation.random(random_state=seed).as_matrix(), 10.0**exponent
        surface = MappedSurface.from_map(mapped_shapes.banana)
        other = MappedSurface.from_map(lambda u: unit * (mapped_shapes.banana(u @ Q) @ Q.T))
        hole = IsotropicSchwarzschild(0.7)
        k = surface.mean_curvature(hole, U)
        scaled = other.mean_curvature(IsotropicSchwarzschild(0.7 * unit), U @ Q.T)
        np.testing.assert_allclose(unit * scaled, k, rtol=1e-9, atol=1e-9)


class TestRefusals:
    @pytest.mark.parametrize(
        ("function", "sentence"),
        [
            (
                lambda u: u * [1, 1, -1],
                "the map turns the sphere inside out: it encloses the volume -4.18879",
            ),
            (lambda u: u * [1, 1, 0], "the map is not an immersion: "),
            (
                lambda u: np.stack([u[:, 0], u[:, 1] ** 2, u[:, 2]], axis=1),
                "the map is not an immersion: its",
            ),
            (lambda u: u[:, :2], r"the map has the shape \(200, 2\) for 200 directions, not \(200, 3\)"),
            (lambda u: np.where(u > 0.9, np.nan, u), "the map is .*nan.* in the direction .* is not finite"),
            (lambda u: u * (1 + np.abs(u[:, :1])), "the map is not smooth enough for harmonics"),
            (3.0, r"the map is a float, not a function of unit vectors u \(n, 3\)"),
        ],
    )
    def test_of_maps(self, function, sentence):
        with pytest.raises(InvalidParameter, match=sentence):
            MappedSurface.from_map(function)

    def test_of_coefficients(self):
        with pytest.raises(InvalidParameter, match=r"4 harmonics take coefficients \(4, 3\), not \(4,\)"):
            MappedSurface(Harmonics(1, 1), np.ones(4))
        with pytest.raises(InvalidParameter, match="the center must be three finite numbers"):
            MappedSurface.from_map(mapped_shapes.ellipsoid, (0, 0))


@cache
def banana():
    """A banana beside a black hole: a mesh, the slice, the surface from the mesh, and that in closed form."""
    x, faces, _ = mapped_shapes.mesh(mapped_shapes.banana, 800)
    hole = BrillLindquist([1.0, 0.5], [(0, 0.0, -0.6), (0.3, 0, 5)])
    return x, faces, hole, MappedSurface.from_mesh(x, faces), MappedSurface.from_map(mapped_shapes.banana)


def integrals(surface, geometry):
    """The area and the integral of k."""
    u, weights = gauss_rule(48, 96)
    local = surface.local_geometry(geometry, u)
    areas = weights * area_density(local.q)
    return areas.sum(), areas @ local.mean_curvature


class TestMeshes:
    def test_integrals_are_as_stated(self):
        *_, hole, surface, exact = banana()
        (area, total), (true, true_total) = integrals(surface, hole), integrals(exact, hole)
        data = surface.data(hole)
        lengths, k = data.lengths_error.mean, data.mean_curvature.error.mean
        assert abs(area / true - 1) < 2 * lengths < 1e-5
        assert abs(total - true_total) < k * true + 2 * lengths * abs(true_total)
        assert k < 1e-4

    def test_labels_turns_and_scales(self):
        x, faces, hole, surface, _ = banana()
        A, K = integrals(surface, hole)
        order = np.random.default_rng(2).permutation(len(x))
        again = MappedSurface.from_mesh(x[order], np.argsort(order)[faces[:, ::-1]])
        np.testing.assert_allclose(integrals(again, hole), (A, K), rtol=1e-6)
        Q, unit = Rotation.random(random_state=1).as_matrix(), 1e6
        moved = BrillLindquist([unit * m for m in hole.masses], unit * np.array(hole.positions) @ Q.T)
        scaled = MappedSurface.from_mesh(unit * x @ Q.T, faces)
        np.testing.assert_allclose(integrals(scaled, moved), (A * unit**2, K * unit), rtol=1e-6)

    def test_of_a_horizon(self):
        horizon = StarSurface.from_radius(HOLE.spheroid(HOLE.horizon))
        x, faces, _ = mapped_shapes.mesh(lambda u: horizon.points(turned(u)), 300)
        found = MappedSurface.from_mesh(x, faces)
        stated = found.data(HOLE).mean_curvature.error.pointwise
        assert np.abs(found.expansion(HOLE, U)).max() < max(2 * stated, 1e-9)
        assert found.angular_momentum(HOLE, HOLE.spin) == pytest.approx(np.sqrt(0.7), rel=1e-9)

    def test_noise_is_within_the_errors(self):
        x, faces, hole, _, exact = banana()
        noisy = MappedSurface.from_mesh(x + 1e-3 * np.random.default_rng(5).normal(size=x.shape), faces)
        data, (area, _), (true, _) = noisy.data(hole), integrals(noisy, hole), integrals(exact, hole)
        assert abs(area / true - 1) < 2 * data.lengths_error.mean < 1e-2

    @pytest.mark.parametrize(
        ("change", "error", "sentence"),
        [
            (lambda x, f: (x[:, :2], f), InvalidParameter, r"points must be an array \(m, 3\)"),
            (lambda x, f: (x + [[0, 0, 0], [np.inf, 0, 0]] * 6, f), InvalidParameter, "point 1 is .*inf"),
            (lambda x, f: (np.concatenate([x, x]), f), InvalidMetric, "24 vertices, but 12 in faces"),
            (lambda x, f: (x, f[1:]), InvalidMetric, "edge"),
        ],
    )
    def test_refusals(self, change, error, sentence):
        x, faces = zoo.icosahedron()
        with pytest.raises(error, match=sentence):
            MappedSurface.from_mesh(*change(x, faces))

    def test_a_surface_may_meet_itself(self):
        def ring(u):
            return mapped_shapes.banana(u, spine=1.2, axes=(4.0, 0.8, 0.7))

        x, faces, _ = mapped_shapes.mesh(ring, 700)
        surface = MappedSurface.from_mesh(x, faces)
        assert any(
            "the mesh intersects itself, for instance in faces" in note for note in surface.data(FLAT).notes
        )
        exact = MappedSurface.from_map(ring)
        assert integrals(surface, FLAT)[0] == pytest.approx(integrals(exact, FLAT)[0], rel=1e-5)
        assert banana()[3].notes == ()

    def test_too_few_vertices(self):
        x, faces, _ = mapped_shapes.mesh(mapped_shapes.peanut, 100)
        sentence = "100 vertices are too few or too scattered for a smooth .*: it misses them by .* % of its"
        with pytest.raises(InvalidParameter, match=sentence):
            MappedSurface.from_mesh(x, faces)
