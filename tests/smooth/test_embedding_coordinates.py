"""Embeddings in coordinates of their own: poor directions and tilted axes, seen from the given ones."""

import numpy as np
import pytest

from isoembed.errors import NotEmbedded
from isoembed.gallery import Ellipsoid
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import PulledBack, embed_smooth, gaussian_curvature

U = fibonacci_directions(50)


def seen_from(axes, center):
    """An ellipsoid as r(u) about a center: X(u) and its metric."""
    D, c = np.array(axes) ** -2.0, np.array(center)

    def radius(u):
        a, b = u**2 @ D, u @ (D * c)
        root = np.sqrt(b**2 - a * (c @ (D * c) - 1.0))
        r = (root - b) / a
        # From a r^2 + 2 b r + const = 0.
        return r, -(r[:, None] * u * D + D * c) * (r / root)[:, None]

    def differential(u):
        r, slope = radius(u)
        slope = slope - np.einsum("ni,ni->n", slope, u)[:, None] * u
        return u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)

    return lambda u: c + radius(u)[0][:, None] * u, PulledBack(differential)


class Turned:
    """A metric with its z-axis along another axis."""

    def __init__(self, metric, axis):
        z = np.array(axis) / np.linalg.norm(axis)
        x = np.cross(z, [0.3, -0.8, 0.4])
        x /= np.linalg.norm(x)
        self.metric, self.Q = metric, np.stack([x, np.cross(z, x), z], axis=1)

    def tensor(self, u):
        return self.Q @ self.metric.tensor(u @ self.Q) @ self.Q.T


def distances(x):
    return np.linalg.norm(x[:, None] - x, axis=2)


@pytest.mark.parametrize("center", [(0.0, 0.0, 0.0), pytest.param((1.2, 0.6, 0.3), marks=pytest.mark.slow)])
def test_an_ellipsoid_as_a_radius(center):
    """In the directions that are given it is of degree 80."""
    points, metric = seen_from((3.0, 2.0, 1.0), center)
    found = embed_smooth(metric, vertices=300)
    exact = Ellipsoid((3, 2, 1)).integrated_mean_curvature
    assert found.coordinates is not None and found.harmonics.degree <= 24
    assert abs(found.integrated_mean_curvature / exact - 1.0) < 1e-12
    assert abs(found.integrated_mean_curvature - exact) <= found.curvature_error + 1e-13 * exact
    np.testing.assert_allclose(distances(found.points(U)), distances(points(U)), atol=1e-9)
    np.testing.assert_allclose(found.gaussian_curvature(U), gaussian_curvature(metric, U), rtol=1e-6)
    assert found.strain(U).max() < 1e-6
    x, n = found.points(U), found.normals(U)
    assert np.einsum("ni,ni->n", x, n).min() > 0.5
    own = found.in_own_directions
    v = found.coordinates.inverse(U)
    np.testing.assert_array_equal(own.points(v), x)
    assert own.integrated_mean_curvature == found.integrated_mean_curvature


def test_it_lies_as_the_directions_do():
    """Turned onto the given directions, not onto those of the harmonics."""
    points, metric = seen_from((3.0, 2.0, 1.0), (0.0, 0.0, 0.0))
    found = embed_smooth(metric, vertices=300, shape=points)
    np.testing.assert_allclose(found.points(U), points(U), atol=1e-9)


@pytest.mark.slow
def test_a_start_is_in_coordinates_of_its_own():
    first = embed_smooth(seen_from((3.0, 2.0, 1.0), (0.0, 0.0, 0.0))[1], vertices=300)
    points, metric = seen_from((3.0, 2.1, 1.0), (0.0, 0.0, 0.0))
    found = embed_smooth(metric, start=first)
    assert found.coordinates is first.coordinates
    np.testing.assert_allclose(distances(found.points(U)), distances(points(U)), atol=1e-6)
    tilted = Turned(KerrNewmanHorizon(1.0, 0.5), (1.0, 2.0, 3.0))
    second = embed_smooth(tilted, start=embed_smooth(KerrNewmanHorizon(1.0, 0.45), vertices=200))
    assert second.harmonics.order == 1 and second.coordinates is not None


def test_a_tilted_axis_costs_as_little_as_z():
    exact = embed_smooth(KerrNewmanHorizon(1.0, 0.8), vertices=200)
    metric = Turned(KerrNewmanHorizon(1.0, 0.8), (1.0, 2.0, 3.0))
    found = embed_smooth(metric, vertices=200)
    assert found.harmonics == exact.harmonics
    assert abs(found.integrated_mean_curvature / exact.integrated_mean_curvature - 1.0) < 1e-13
    np.testing.assert_allclose(found.points(U @ metric.Q.T), exact.points(U) @ metric.Q.T, atol=1e-11)


@pytest.mark.parametrize("spin", [0.867, pytest.param(0.9, marks=pytest.mark.slow)])
def test_a_tilted_horizon_is_refused_exactly(spin):
    with pytest.raises(
        NotEmbedded,
        match=r"^with theta from the axis of symmetry \(0, 0.6, 0.8\), no surface of revolution has",
    ):
        embed_smooth(Turned(KerrNewmanHorizon(1.0, spin), (0.0, 3.0, 4.0)), vertices=200)


@pytest.mark.parametrize("axes", [(1.3, 1.1, 1.0), (2.0, 2.0, 1.0)])
def test_where_nothing_is_gained_there_is_one_kind_of_directions(axes):
    found = embed_smooth(seen_from(axes, (0.0, 0.0, 0.0))[1], vertices=200)
    assert found.coordinates is None and found.in_own_directions is found
