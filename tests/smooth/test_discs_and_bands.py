"""Discs and bands in smooth metrics: geodesic lengths and sheets against closed forms."""

import numpy as np
import pytest

from isoembed import InvalidMetric, InvalidParameter, embed
from isoembed.meshing.sphere import angles_of, fibonacci_directions
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import (
    AngleMetric,
    ChartMetric,
    GridMetric,
    gaussian_curvature,
    geodesic_lengths,
    triangulate_metric,
)
from isoembed.surface.alignment import distance

HYPERBOLIC = AngleMetric(lambda r, phi: (1.0, 0.0, np.sinh(r) ** 2))
ROUND = AngleMetric(lambda r, phi: (1.0, 0.0, np.sin(r) ** 2))


def poincare(x, y):
    factor = 4 / (1 - x * x - y * y) ** 2
    return factor, 0 * x, factor


def hyperboloid(r, phi):
    return np.stack([np.cosh(r), np.sinh(r) * np.cos(phi), np.sinh(r) * np.sin(phi)], axis=1)


def hyperbolic_distances(a, b):
    d = a - b
    return 2 * np.arcsinh(np.sqrt(d[:, 1] ** 2 + d[:, 2] ** 2 - d[:, 0] ** 2) / 2)


def by_polar(u):
    return hyperboloid(*angles_of(u))


def by_poincare(u):
    x, y = ChartMetric.coordinates(u).T
    return hyperboloid(2 * np.arctanh(np.hypot(x, y)), np.arctan2(y, x))


@pytest.mark.parametrize(
    ("metric", "points", "radius", "bound"),
    [(HYPERBOLIC, by_polar, 2.0, 1e-8), (ChartMetric(poincare), by_poincare, np.tanh(1.0), 1e-9)],
    ids=["polar", "Poincare"],
)
def test_lengths_are_hyperbolic_distances(metric, points, radius, bound):
    errors = []
    for n in (960, 3840):
        mesh = triangulate_metric(metric, n, zone=(0.0, radius))
        i, j = mesh.metric.edges.T
        x = points(mesh.directions)
        errors.append(np.abs(mesh.metric.lengths / hyperbolic_distances(x[i], x[j]) - 1).max())
    assert errors[1] < bound
    assert np.log2(errors[0] / errors[1]) > 4


@pytest.mark.parametrize("n", [12, 100, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("metric", "zone"),
    [
        (HYPERBOLIC, (0.0, 1.0)),
        (ROUND, (0.4, 1.2)),
        (KerrNewmanHorizon(spin=0.95), (1.0, 2.1)),
        (KerrNewmanHorizon(spin=0.95), (2.0, np.pi)),
        (ChartMetric(lambda x, y: (1 + x**2, x * y, 2 + y**2)), (0.0, 1.0)),
    ],
    ids=["hyperbolic", "zone of a sphere", "band of a horizon", "about the south pole", "anisotropic"],
)
def test_triangles_are_nearly_equilateral(metric, zone, n):
    mesh = triangulate_metric(metric, n, zone=zone)
    t = mesh.metric.triangulation
    assert t.n_vertices == n
    assert [t.genus, len(t.boundaries)] == [0, sum(0 < theta < np.pi for theta in zone)]
    rim = np.concatenate(t.boundaries)
    assert set(rim) == set(range(len(rim)))
    theta, phi = mesh.polar
    np.testing.assert_allclose(np.sin(theta) * np.cos(phi), mesh.directions[:, 0], atol=1e-14)
    for loop in t.boundaries:
        assert np.ptp(theta[loop]) < 1e-12
        assert np.abs(np.array(zone) - theta[loop[0]]).min() < 1e-12
    least, most = np.degrees(mesh.angles)
    assert least > 30
    assert most < 105
    along = mesh.metric.lengths[t.boundary_edges]
    assert along.max() < (1.2 if n == 1000 else 1.6) * along.min()


@pytest.mark.slow
def test_coarse_anisotropic_bands_keep_their_boundaries():
    metric = ChartMetric(lambda x, y: (16.0, 0 * x, 1 + 0 * x))
    for zone, n in (((1.2, 1.5), 120), ((0.3, 1.5), 40), ((0.0, 1.5), 20)):
        t = triangulate_metric(metric, n, zone=zone).metric.triangulation
        rim = np.concatenate(t.boundaries)
        assert len(t.boundaries) == 1 + (zone[0] > 0)
        assert set(rim) == set(range(len(rim)))


def test_size_is_the_mean_length():
    for zone in ((0.0, 1.5), (0.5, 1.5)):
        mesh = triangulate_metric(HYPERBOLIC, size=0.1, zone=zone)
        assert mesh.metric.mean_length == pytest.approx(0.1, rel=0.03)


def test_grading_gives_the_curvature_its_share():
    """A bump on a plane."""

    def components(x, y):
        slope = -2 * np.exp(-8 * (x * x + y * y)) * 4
        return 1 + (slope * x) ** 2, slope**2 * x * y, 1 + (slope * y) ** 2

    def near(grading):
        mesh = triangulate_metric(ChartMetric(components), 800, zone=(0.0, 1.5), grading=grading)
        return np.count_nonzero(mesh.directions[:, 2] > np.cos(0.6))

    assert near(0.5) > 1.15 * near(0.0)


def test_a_band_has_no_poles_and_needs_none():
    def components(theta, phi):
        if np.any((theta < 0.9) | (theta > 2.2)):
            raise ValueError("outside")
        return 1.0, 0.0, np.cosh(theta - 1.5) ** 2

    mesh = triangulate_metric(AngleMetric(components), 100, zone=(1.0, 2.0))
    assert np.ptp(mesh.metric.lengths) < mesh.metric.mean_length


def test_grids_have_zones():
    kerr = KerrNewmanHorizon(spin=0.5)
    grid = GridMetric.sampled(kerr, 48, 16)
    one, other = (triangulate_metric(metric, 80, zone=(0.8, 2.0)) for metric in (kerr, grid))
    np.testing.assert_allclose(one.measured(kerr).lengths, one.measured(grid).lengths, rtol=1e-6)
    assert other.metric.triangulation.n_vertices == 80


def test_components_in_x_and_y_are_those_in_polar_coordinates():
    def components(x, y):  # of the hyperbolic plane
        r = np.maximum(np.hypot(x, y), 1e-3)
        excess = np.where(r > 1e-3, (np.sinh(r) ** 2 / r**2 - 1) / r**2, 1 / 3)
        return 1 + excess * y * y, -excess * x * y, 1 + excess * x * x

    chart = ChartMetric(components)
    u = fibonacci_directions(100)
    u = np.concatenate([u[u[:, 2] > -0.8], [[0.0, 0.0, 1.0]]])
    size = HYPERBOLIC.tensor(u).max()
    np.testing.assert_allclose(chart.tensor(u), HYPERBOLIC.tensor(u), atol=1e-8 * size)
    np.testing.assert_allclose(gaussian_curvature(chart, u[u[:, 2] > 0]), -1, rtol=1e-6)
    x, y = chart.coordinates(u).T
    np.testing.assert_allclose(np.cos(np.hypot(x, y)), u[:, 2], atol=1e-14)


def test_caps_embed_with_the_second_order():
    errors = []
    for n in (100, 400, 1600):
        mesh = triangulate_metric(ROUND, n, zone=(0.0, 1.0))
        found = embed(mesh.metric, boundary="plane")
        assert found.residual < 1e-12
        errors.append(distance(found.vertices, mesh.directions))
    assert errors[-1] < 2e-4
    assert 3.2 < np.log2(errors[0] / errors[2]) < 5.0


def test_bands_of_horizons_embed():
    """One that spins too fast to embed whole."""
    horizon = KerrNewmanHorizon(spin=0.95)
    mesh = triangulate_metric(horizon, 200, zone=(1.1, np.pi - 1.1))
    found = embed(mesh.metric, boundary="free")
    assert found.residual < 1e-12
    rho = horizon.profile().rho(mesh.polar[0])
    axis = np.linalg.svd(found.vertices - found.vertices.mean(axis=0))[2][2]
    off = found.vertices - found.vertices.mean(axis=0)
    off -= np.outer(off @ axis, axis)
    assert np.abs(np.linalg.norm(off, axis=1) / rho - 1).max() < 0.02


@pytest.mark.parametrize(
    ("metric", "options", "error", "sentence"),
    [
        (ROUND, {"zone": (1.0, 0.5)}, InvalidParameter, r"two angles with 0 <= start < stop <= pi, not \(1"),
        (ROUND, {"zone": (0.0, 4.0)}, InvalidParameter, r"not \(0.0, 4.0\)"),
        (ROUND, {"zone": 1}, InvalidParameter, "two angles with .* not 1$"),
        (
            AngleMetric(lambda r, phi: (1.0, 0.0, np.sinh(r) ** 2)),
            {},
            InvalidMetric,
            r"not smooth at the poles.*takes triangulate_metric\(..., zone=\(0, stop\)\)$",
        ),
        (ROUND, {"zone": (0.0, 1e-9), "vertices": 5}, InvalidParameter, "at least 12, not 5"),
        (ROUND, {"zone": (1.0, 1.02)}, InvalidParameter, "are too few: nearly equilateral triangles"),
        (
            AngleMetric(lambda r, phi: (1.0, 0.0, 0.5 * np.sin(r) ** 2)),
            {"zone": (0.0, 1.0)},
            InvalidMetric,
            "not smooth at the poles: .* a cone",
        ),
        (
            AngleMetric(lambda r, phi: (1.0 + 0.1 * np.cos(0.5 * phi), 0.0, np.sin(r) ** 2)),
            {"zone": (0.5, 1.0)},
            InvalidMetric,
            "at phi = 0 and .* at phi = 2 pi",
        ),
        (
            ChartMetric(lambda x, y: (1 - x, 0 * x, 1 + 0 * x)),
            {"zone": (0.0, 1.5)},
            InvalidMetric,
            r"g_xx, g_xy, g_yy = -.* at x = 1.\d+, y = .*: that is not a positive definite metric",
        ),
    ],
)
def test_refusals(metric, options, error, sentence):
    with pytest.raises(error, match=sentence):
        triangulate_metric(metric, options.pop("vertices", 40), **options)


def test_no_directions_have_no_lengths_and_no_curvature():
    none = np.zeros((0, 3))
    assert geodesic_lengths(ROUND, none, none).shape == gaussian_curvature(ROUND, none).shape == (0,)
