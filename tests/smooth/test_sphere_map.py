"""Maps of the sphere onto itself: against closed forms and differences, forth and back; metrics in them."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.smooth import Harmonics, PulledBack, Uncertainty, gaussian_curvature
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import area_density

A = np.array([[3.0, 0.4, 0.0], [-0.2, 2.0, 0.1], [0.0, 0.3, 1.0]])
V = fibonacci_directions(300)


def bent(size=0.05):
    """A map of degree 6 that is nothing special; its Jacobian is between 0.2 and 6."""
    harmonics = Harmonics(6, 6)
    linear = SphereMap.linear(np.diag([3.0, 2.0, 1.0]))
    noise = np.random.default_rng(0).normal(size=(harmonics.size, 3))
    noise /= (1.0 + harmonics.labels[0][:, None]) ** 1.5
    return SphereMap(harmonics, resized(linear.coefficients, linear.harmonics, harmonics) + size * noise)


def unit(x):
    return x / np.linalg.norm(x, axis=1)[:, None]


def test_linear_maps():
    np.testing.assert_allclose(SphereMap.linear(A).forward(V), unit(V @ A.T), atol=1e-15)


def test_rotations_preserve_lengths_and_areas():
    R = np.linalg.qr(A)[0]
    turn = SphereMap.linear(R if np.linalg.det(R) > 0.0 else -R)
    np.testing.assert_allclose(turn.jacobian(V), 1.0, rtol=1e-14)
    D = turn.differential(V)
    np.testing.assert_allclose(
        D.transpose(0, 2, 1) @ D, np.eye(3) - V[:, :, None] * V[:, None, :], atol=1e-14
    )


def test_the_differential_is_that_of_the_map():
    tangent = np.cross(V, [0.3, 0.4, 0.5])
    step = 1e-5
    there, back = (bent().forward(unit(V + sign * step * tangent)) for sign in (1.0, -1.0))
    expected = np.einsum("nij,nj->ni", bent().differential(V), tangent)
    np.testing.assert_allclose((there - back) / (2.0 * step), expected, atol=1e-8)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", bent().differential(V), V), 0.0, atol=1e-14)


def test_the_jacobian_covers_the_sphere_once():
    v, weights = gauss_rule(60, 120)
    assert abs(weights @ bent().jacobian(v) - 4.0 * np.pi) < 1e-11


@pytest.mark.parametrize("coordinates", [bent(), SphereMap.linear(np.diag([30.0, 1.0, 1.0]))])
def test_forth_and_back(coordinates):
    np.testing.assert_allclose(coordinates.inverse(coordinates.forward(V)), V, atol=2e-13)
    np.testing.assert_allclose(coordinates.forward(coordinates.inverse(V)), V, atol=2e-15)
    assert coordinates.inverse(V[:0]).shape == (0, 3)


def test_what_folds_or_does_not_fit_is_refused():
    with pytest.raises(
        InvalidParameter, match=r"^the map of the sphere folds: its Jacobian is -\S+ in the dir"
    ):
        bent(1.0)
    with pytest.raises(InvalidParameter, match="folds"):
        SphereMap.linear(-np.eye(3))
    with pytest.raises(InvalidParameter, match=r"4 harmonics takes as many triples, not \(3, 3\)"):
        SphereMap(Harmonics(1, 1), np.eye(3))


def test_a_metric_in_other_directions_is_the_same_metric():
    ellipsoid = PulledBack(lambda u: np.broadcast_to(A, (len(u), 3, 3)), error=Uncertainty(1e-3, 1e-4))
    metric, F = metric_in(ellipsoid, bent()), bent()
    assert metric.error == ellipsoid.error
    np.testing.assert_allclose(
        gaussian_curvature(metric, V[:40]), gaussian_curvature(ellipsoid, F.forward(V[:40])), rtol=1e-5
    )
    np.testing.assert_allclose(
        area_density(metric.tensor(V)),
        area_density(ellipsoid.tensor(F.forward(V))) * F.jacobian(V),
        rtol=1e-12,
    )


def test_an_ellipsoid_as_a_radius_is_linear_in_the_right_directions():
    axes = np.array([3.0, 2.0, 1.0])

    def differential(u):
        r = (u**2 @ axes**-2) ** -0.5
        slope = -(r[:, None] ** 3) * u / axes**2
        slope -= np.einsum("ni,ni->n", slope, u)[:, None] * u
        return u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)

    linear = PulledBack(lambda u: np.broadcast_to(np.diag(axes), (len(u), 3, 3)))
    found = metric_in(PulledBack(differential), SphereMap.linear(np.diag(axes)))
    np.testing.assert_allclose(found.tensor(V), linear.tensor(V), atol=1e-13)
