"""Smooth embeddings in hyperbolic and spherical space: discarded coordinates, closed forms, rates."""

from dataclasses import dataclass

import numpy as np
import pytest

from isoembed import embed
from isoembed.errors import InvalidParameter
from isoembed.gallery import HarmonicSurface
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import (
    AngleMetric,
    Harmonics,
    PulledBack,
    SmoothEmbedding,
    embed_smooth,
    gaussian_curvature,
    least_hyperbolic,
    triangulate_metric,
)
from isoembed.smooth.gauss_newton import gauss_newton, is_direct
from isoembed.smooth.isometry import IsometrySystem, MetricSamples
from isoembed.smooth.matrix_free import MatrixFreeIsometry
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized
from isoembed.space import Euclidean, Hyperbolic, Space, Spherical

A = np.array([[1.2, 0.3, -0.2], [0.0, 0.9, 0.4], [0.1, 0.0, 0.7]])
SPACES = [Hyperbolic(0.5), Hyperbolic(5.0), Spherical(0.3)]
APART = fibonacci_directions(150)


def induced(A, space):
    """The metric of the surface with the ambient coordinates A u."""
    k = space.curvature

    def ambient(u):
        x = u @ A.T
        w2 = 1.0 - k * np.einsum("ni,ni->n", x, x)
        return np.eye(3) + k * x[:, :, None] * x[:, None, :] / w2[:, None, None]

    return PulledBack(lambda u: np.broadcast_to(A, (len(u), 3, 3)), ambient)


def linear(harmonics, A):
    """Coefficients of A u."""
    C = np.zeros((harmonics.size, 3))
    place = {label: k for k, label in enumerate(zip(*harmonics.labels, strict=True))}
    for column, label in enumerate(((1, 1), (1, -1), (1, 0))):
        C[place[label]] = A[:, column] * np.sqrt(4.0 * np.pi / 3.0)
    return C


def realized(A, space, degree=1):
    harmonics = Harmonics(degree, degree)
    return SmoothEmbedding(induced(A, space), harmonics, linear(harmonics, A), 1e-6, np.inf, space=space)


def disturbed(harmonics, C, size, seed=0):
    noise = np.random.default_rng(seed).standard_normal(C.shape)
    return C + size * noise / (1.0 + harmonics.labels[0][:, None]) ** 3


def distances(surface):
    x = surface.points(APART)
    return surface.space.distances(x[:, None], x[None])


@pytest.mark.parametrize(
    ("space", "degree", "far"),
    [
        *((space, 6, 0.1) for space in SPACES),
        (Hyperbolic(5.0), 24, 0.01),
        pytest.param(Spherical(0.3), 24, 0.01, marks=pytest.mark.slow),
    ],
)
def test_coordinates_that_were_discarded(space, degree, far):
    harmonics = Harmonics(degree, degree)
    assert is_direct(harmonics) == (degree == 6)  # with matrices, and without
    exact = realized(A, space)
    start = disturbed(harmonics, linear(harmonics, A), far)
    C = gauss_newton(exact.metric, harmonics, start, space=space)
    found = SmoothEmbedding(exact.metric, harmonics, C, 1e-6, np.inf, space=space)
    assert found.residual <= 1e-12
    np.testing.assert_allclose(distances(found), distances(exact), atol=1e-12)
    for name in ("area", "volume", "integrated_mean_curvature"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=1e-12)


@pytest.mark.parametrize("space", SPACES, ids=str)
def test_measures(space):
    exact = realized(A, space)
    # The volume element of ambient coordinates is d^3x / w; on shells of A u:
    radii, weights = np.polynomial.legendre.leggauss(40)
    u, around = gauss_rule(40, 80)
    squares = np.einsum("ni,ni->n", u @ A.T, u @ A.T)
    shells = [around @ (r**2 / np.sqrt(1.0 - space.curvature * r**2 * squares)) for r in 0.5 * (radii + 1.0)]
    volume = np.linalg.det(A) * 0.5 * weights @ shells
    assert exact.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(
        exact.gaussian_curvature(APART), gaussian_curvature(exact.metric, APART), rtol=1e-7, atol=1e-8
    )
    # Parallel surfaces: the area grows by 2 int H dA.
    harmonics = Harmonics(30, 30)
    transform = SphereTransform(harmonics, 48, 96)
    x, n = exact.points(transform.u), exact.normals(transform.u)
    step = 1e-3
    areas = []
    for t in np.array([-2.0, -1.0, 1.0, 2.0]) * step:
        C = transform.analysis(x * space.cs(t) + n * space.sn(t))
        samples = SmoothEmbedding(exact.metric, harmonics, C, 1.0, np.inf, space=space)
        stretched = samples._surface(transform.u).stretch
        areas.append(stretched @ MetricSamples.of(exact.metric, 48, 96).areas)
    slope = np.array([1.0, -8.0, 8.0, -1.0]) @ areas / (12.0 * step)
    assert exact.integrated_mean_curvature == pytest.approx(0.5 * slope, rel=1e-9)


@pytest.mark.parametrize("space", [Hyperbolic(2.0), Spherical(0.5)], ids=str)
def test_a_geodesic_sphere_away_from_the_origin(space):
    r, a = 0.6, np.array([0.3, -0.2, 0.4])
    harmonics = Harmonics(2, 2)
    transform = SphereTransform(harmonics, 8, 16)
    C = transform.analysis(space.translated(float(space.sn(r)) * transform.u, a))
    sn, cs = float(space.sn(r)), float(space.cs(r))
    round_metric = AngleMetric(lambda t, _: (sn**2 + 0.0 * t, 0.0, (sn * np.sin(t)) ** 2))
    found = SmoothEmbedding(round_metric, harmonics, C, 1e-6, np.inf, space=space)
    assert found.residual <= 1e-13
    np.testing.assert_allclose(found.mean_curvature(APART), cs / sn, rtol=1e-12)
    np.testing.assert_allclose(found.gaussian_curvature(APART), 1.0 / sn**2, rtol=1e-12)
    # From the sphere inwards along the normals: the center.
    inwards = found.points(APART) * cs - found.normals(APART) * sn
    np.testing.assert_allclose(inwards, np.broadcast_to(a, inwards.shape), atol=1e-12)
    np.testing.assert_allclose(found.integrated_mean_curvature, 4.0 * np.pi * sn * cs, rtol=1e-12)


@pytest.mark.parametrize("space", SPACES, ids=str)
def test_the_correction_is_of_first_order(space):
    # Of int H dA + k volume: what is left is of second order in the error of the metric.
    exact, harmonics = realized(A, space), Harmonics(4, 4)
    errors = []
    for size in (1e-2, 1e-3):
        C = disturbed(harmonics, linear(harmonics, A), size)
        found = SmoothEmbedding(exact.metric, harmonics, C, 1.0, np.inf, space=space)
        sums = [s.integrated_mean_curvature + space.curvature * s.volume for s in (found, exact)]
        errors.append(abs(sums[0] - sums[1]))
    assert 60.0 < errors[0] / errors[1] < 160.0


@pytest.mark.parametrize("space", SPACES, ids=str)
def test_deformations_of_first_order(space):
    harmonics = Harmonics(5, 5)
    metric, C = induced(A, space), disturbed(harmonics, linear(harmonics, A), 0.02)
    dense = IsometrySystem.of(harmonics, MetricSamples.of(metric, 12, 24), space)
    transform = SphereTransform(harmonics, 12, 24)
    fast = MatrixFreeIsometry.of(transform, MetricSamples.of(metric, 12, 24), space)
    change = np.random.default_rng(1).standard_normal(C.shape) / (1.0 + harmonics.labels[0][:, None])
    step = 1e-5
    # Without what a rotation does, which is a null direction.
    above, below = (dense._tangents((C + sign * step * change)[1:] / dense.unit).strains for sign in (1, -1))
    strain = (above - below) / (2.0 * step)
    for system in (dense, fast):
        found = system.deformations(C, strain[None])[0]
        above, below = (
            dense._tangents((C + sign * step * found)[1:] / dense.unit).strains for sign in (1, -1)
        )
        np.testing.assert_allclose((above - below) / (2.0 * step), strain, atol=2e-4 * np.abs(strain).max())


@pytest.mark.parametrize("degree", [6, 24])
def test_a_start_beyond_the_hemisphere_is_refused(degree):
    harmonics, space = Harmonics(degree, degree), Spherical(0.3)
    with pytest.raises(InvalidParameter, match="starting points are not all in the hemisphere about"):
        gauss_newton(induced(A, space), harmonics, 3.0 * linear(harmonics, A), space=space)


def test_flat_space_is_the_limit_at_a_linear_rate():
    harmonics = Harmonics(8, 8)
    metric = induced(np.diag([1.2, 1.0, 0.8]), Euclidean())

    def value(k):
        C = gauss_newton(metric, harmonics, linear(harmonics, np.diag([1.2, 1.0, 0.8])), space=Space(k))
        surface = SmoothEmbedding(metric, harmonics, C, 1e-6, np.inf, space=Space(k))
        return surface.integrated_mean_curvature, surface.volume

    flat = np.array(value(0.0))
    changes = np.array([value(k) - flat for k in (1e-3, 1e-4, -1e-4)])
    np.testing.assert_allclose(changes[0] / changes[1], 10.0, rtol=0.01)
    np.testing.assert_allclose(changes[1] / changes[2], -1.0, rtol=0.01)


@dataclass(frozen=True)
class Turned:
    """A metric that has been turned by an orthogonal matrix."""

    metric: object
    Q: np.ndarray

    def tensor(self, u):
        return self.Q @ self.metric.tensor(u @ self.Q) @ self.Q.T


TURN = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [-0.3, 1.0, 0.5], [0.1, -0.6, 1.0]]))[0]

KERR = {
    1.0: 2.019656395202,
    0.95: 1.9343168808,
    0.9: 1.8343379378,
    0.99: 2.0102107853,
}
SLOW = [
    pytest.param(spin, tilted, marks=pytest.mark.slow)
    for spin in (0.9, 0.95, 0.99)
    for tilted in (False, True)
]


@pytest.mark.parametrize(("spin", "tilted"), [(1.0, True), *SLOW])
def test_kerr_horizons_beyond_smarrs_limit(spin, tilted):
    horizon = KerrNewmanHorizon(1.0, spin)
    metric = Turned(horizon, TURN * np.linalg.det(TURN)) if tilted else horizon
    found = embed_smooth(metric, space=least_hyperbolic(metric).space)
    assert found.converged and found.mesh is None and found.harmonics.order == 1
    assert found.integrated_mean_curvature / (4.0 * np.pi) == pytest.approx(KERR[spin], abs=1e-10)
    assert found.curvature_error < 1e-8


@dataclass(frozen=True)
class Disturbed:
    """A metric whose symmetry about z is broken: some dx^2 more."""

    metric: object

    def tensor(self, u):
        slope = [1.0, 0.0, 0.0] - u[:, :1] * u
        return self.metric.tensor(u) + 0.02 * slope[:, :, None] * slope[:, None, :]


def test_a_start_in_place_of_a_mesh():
    space = Hyperbolic(0.5)
    start = embed_smooth(induced(np.diag([1.2, 1.2, 0.9]), space), space=space)
    exact = realized(A, space)
    found = embed_smooth(exact.metric, space=space, start=start)
    assert found.converged and found.space == space and found.coordinates is None
    np.testing.assert_allclose(distances(found), distances(exact), atol=1e-11)
    mesh = found.triangulated(50)
    assert mesh.metric.space == space


@pytest.mark.slow
@pytest.mark.parametrize("space", [Hyperbolic(0.5), Spherical(0.3)], ids=str)
def test_a_mesh_finds_the_surface(space):
    exact = realized(A, space)
    found = embed_smooth(exact.metric, space=space, vertices=250)
    np.testing.assert_allclose(distances(found), distances(exact), atol=1e-11)
    # As it has been turned to the directions, its centroid in the origin.
    np.testing.assert_allclose(found.coefficients[0], 0.0, atol=1e-12)


@pytest.mark.slow
def test_without_symmetry_in_the_least_curvature():
    metric = Disturbed(KerrNewmanHorizon(1.0, 0.95))
    least = least_hyperbolic(metric)
    assert least.of_revolution is None and least.space.curvature == least.gaussian_curvature
    assert least.gaussian_curvature == pytest.approx(-0.1419929017139926, rel=1e-9)
    start = embed_smooth(metric.metric, space=least_hyperbolic(metric.metric).space, accuracy=1e-6)
    found = embed_smooth(metric, space=least.space, start=start)
    assert found.converged
    # With harmonics to degree 192 it is 1.9351995862(45).
    error = found.curvature_error / (4.0 * np.pi)
    assert error < 5e-8
    assert abs(found.integrated_mean_curvature / (4.0 * np.pi) - 1.9351995862) <= error


def lopsided(u):
    """Points of a star-shaped surface that is not its own mirror image, and their differential."""
    x, y, z = u.T
    r = 1.0 + 0.1 * x * y + 0.15 * y**3 - 0.2 * z**2 * x + 0.1 * z
    slope = np.stack([0.1 * y - 0.2 * z**2, 0.1 * x + 0.45 * y**2, -0.4 * z * x + 0.1], axis=1)
    return r[:, None] * u, r[:, None, None] * np.eye(3) + u[:, :, None] * slope[:, None, :]


def trefoil(u):
    surface = HarmonicSurface(3, 3, -0.15)
    return surface._points(u), surface._differential(u)


def metric_of(surface, space):
    def ambient(u):
        x = surface(u)[0]
        w2 = 1.0 - space.curvature * np.einsum("ni,ni->n", x, x)
        return np.eye(3) + space.curvature * x[:, :, None] * x[:, None, :] / w2[:, None, None]

    return PulledBack(lambda u: surface(u)[1], ambient)


@pytest.mark.parametrize("space", [Hyperbolic(1.0), Spherical(0.3)], ids=str)
def test_errors_are_no_larger_than_they_are_said_to_be(space):
    metric, degree = metric_of(lopsided, space), Harmonics(4, 4)
    transform = SphereTransform(degree, 6, 12)
    C, last = transform.analysis(lopsided(transform.u)[0]), np.inf
    exact = SmoothEmbedding(metric, degree, C, 1e-4, np.inf, space=space).integrated_mean_curvature
    before = degree
    for harmonics in (Harmonics(4, 4), Harmonics(6, 6), Harmonics(9, 9)):
        C, before = gauss_newton(metric, harmonics, resized(C, before, harmonics), space=space), harmonics
        found = SmoothEmbedding(metric, harmonics, C, 1e-4, last, space=space)
        last = found.integrated_mean_curvature
        assert 1e-12 < abs(last - exact) < found.curvature_error
    assert found.curvature_error < 1e-5 * exact


@pytest.mark.slow
@pytest.mark.parametrize(
    ("surface", "space", "negative"),
    [
        (lopsided, Hyperbolic(9.0), False),
        (lopsided, Spherical(0.4), False),
        (trefoil, Hyperbolic(1.0), False),
        (trefoil, Spherical(0.4), True),
        (trefoil, Hyperbolic(0.1), True),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_bodies_without_symmetry(surface, space, negative):
    found = embed_smooth(metric_of(surface, space), space=space, vertices=400)
    assert (found.least_curvature < space.curvature) == negative
    points = surface(APART)[0]
    np.testing.assert_allclose(
        distances(found), space.distances(points[:, None], points[None]), rtol=0.0, atol=1e-9
    )


@pytest.mark.slow
def test_meshes_in_the_least_curvature_are_of_second_order():
    horizon = KerrNewmanHorizon(1.0, 0.95)
    errors = []
    for vertices in (300, 2400):
        mesh = triangulate_metric(horizon, vertices, space=least_hyperbolic(horizon).space)
        embedding = embed(mesh.metric)
        errors.append(abs(embedding.integrated_mean_curvature / (4.0 * np.pi) - KERR[0.95]))
    assert errors[1] < 2e-3 and 5.0 < errors[0] / errors[1] < 13.0
