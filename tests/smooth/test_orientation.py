"""Place of an embedded surface in space: that of the closed form, of the shape that is given."""

from dataclasses import dataclass

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import AxisymmetricEmbedding, PulledBack, embed_smooth
from isoembed.smooth.two_metric import TwoMetric, area_density

U = fibonacci_directions(300)
MIRROR = np.diag([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Turned:
    """A metric that has been turned or mirrored by an orthogonal matrix."""

    metric: TwoMetric
    Q: np.ndarray

    def tensor(self, u):
        return self.Q @ self.metric.tensor(u @ self.Q) @ self.Q.T


def turn():
    """About no particular axis."""
    Q, _ = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-0.3, 1.0, 0.8], [0.4, -0.6, 1.0]]))
    return Q * np.linalg.det(Q)


def pear(u):
    """Points of a convex surface without symmetry, far from the origin."""
    x, y, z = u.T
    r = 1.0 + 0.04 * x * y + 0.03 * y**3 - 0.05 * z**2 * x + 0.1 * z
    return r[:, None] * u * [1.0, 1.1, 0.9] + [5.0, -3.0, 2.0]


def differential(u):
    """That of the pear."""
    x, y, z = u.T
    r = 1.0 + 0.04 * x * y + 0.03 * y**3 - 0.05 * z**2 * x + 0.1 * z
    slope = np.stack([0.04 * y - 0.05 * z**2, 0.04 * x + 0.09 * y**2, -0.1 * z * x + 0.1], axis=1)
    star = r[:, None, None] * np.eye(3) + u[:, :, None] * slope[:, None, :]
    return np.diag([1.0, 1.1, 0.9]) @ star


PEAR = PulledBack(differential)


def centroid(metric, points):
    u, weights = gauss_rule(40, 80)
    areas = weights * area_density(metric.tensor(u))
    return areas @ points(u) / areas.sum()


@pytest.fixture(scope="module")
def found():
    return embed_smooth(PEAR, vertices=100)


def allowed(found):
    """Distance of points that are uncertain by what the lengths are."""
    return 10.0 * found.residual + 1e-12


@pytest.mark.parametrize("spin", [0.3, 0.7])
def test_the_axis_of_a_closed_form_is_z_and_phi_0_is_a_meridian_along_x(spin):
    horizon = KerrNewmanHorizon(2.0, spin)
    found = embed_smooth(horizon, vertices=100)
    X = found.points(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8]]))
    assert np.abs(X[0, :2]).max() < 1e-14 and X[0, 2] > 0.0
    assert np.abs(X[1, 1:]).max() < 1e-14 and X[1, 0] > 0.0
    assert np.abs(X[2, ::2]).max() < 1e-14 and X[2, 1] > 0.0
    assert abs(X[3, 1]) < 1e-14 and X[3, 0] > 0.0 and X[3, 2] < 0.0
    exact = AxisymmetricEmbedding.of(horizon).points(U)
    assert np.abs(found.points(U) - exact).max() < 100.0 * allowed(found)


def test_the_surface_is_turned_onto_the_shape_that_is_given(found):
    given = embed_smooth(PEAR, start=found, shape=pear)
    expected = pear(U) - centroid(PEAR, pear)
    assert np.abs(given.points(U) - expected).max() < allowed(given)
    assert np.abs(found.points(U) - expected).max() > 1e-3  # the directions are another shape
    assert given.integrated_mean_curvature == pytest.approx(found.integrated_mean_curvature, rel=1e-13)


def test_its_unit_does_not_matter(found):
    large = embed_smooth(PEAR, start=found, shape=lambda u: 1e6 * pear(u))
    small = embed_smooth(PEAR, start=found, shape=lambda u: 1e-6 * pear(u))
    assert np.abs(large.points(U) - small.points(U)).max() < 1e-13


def test_the_centroid_is_the_origin(found):
    assert np.abs(centroid(PEAR, found.points)).max() < 1e-13


def test_neither_mesh_nor_start_matters(found):
    other = embed_smooth(PEAR, vertices=300)
    begun = embed_smooth(PEAR, start=embed_smooth(Turned(PEAR, turn()), vertices=100))
    for again in (other, begun):
        assert np.abs(again.points(U) - found.points(U)).max() < allowed(found)


@pytest.mark.parametrize("Q", [turn() @ MIRROR, pytest.param(MIRROR, marks=pytest.mark.slow)])
def test_a_metric_that_is_turned_or_mirrored_has_a_surface_that_is(found, Q):
    again = embed_smooth(Turned(PEAR, Q), vertices=100)
    assert np.abs(again.points(U) - found.points(U @ Q) @ Q.T).max() < allowed(found)
    assert np.abs(again.normals(U) - found.normals(U @ Q) @ Q.T).max() < 1e3 * allowed(found)
    assert again.integrated_mean_curvature == pytest.approx(found.integrated_mean_curvature, rel=1e-12)
