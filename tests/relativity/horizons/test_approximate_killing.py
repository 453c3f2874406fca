"""The rotations that shear a metric least: round and axisymmetric metrics, and ellipsoids."""

import numpy as np
import pytest

from isoembed.relativity.horizons.approximate_killing import rotations
from isoembed.relativity.spacetimes.kerr import KerrNewmanHorizon, KerrNewmanSphere
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable
from isoembed.smooth.two_metric import PulledBack

FLAT = AnalyticCallable(lambda x: np.broadcast_to(np.eye(3), (len(x), 3, 3)))


def linear(matrix):
    """The metric of the image of the unit sphere under a linear map."""
    return PulledBack(lambda u: np.broadcast_to(matrix, (len(u), 3, 3)))


def ellipsoid(center, axes):
    """An ellipsoid as a star-shaped surface about a point inside."""
    c, scale = np.array(center), 1.0 / np.array(axes, dtype=float)

    def radius(u):
        a, b = np.sum((u * scale) ** 2, axis=1), (u * scale) @ (c * scale)
        return (np.sqrt(b**2 + a * (1.0 - np.sum((c * scale) ** 2))) - b) / a

    return StarSurface.from_radius(radius, center)


@pytest.mark.parametrize("axisymmetric", [True, False])
@pytest.mark.parametrize("scale", [1e-80, 3.0, 1e80])
def test_on_a_round_sphere_they_are_rotations(axisymmetric, scale):
    found = rotations(linear(scale * np.eye(3)), 8, axisymmetric)
    assert found.area == pytest.approx(4.0 * np.pi * scale**2, rel=1e-14)
    assert found.shears.max() < 1e-13
    for i in range(3):
        c = np.einsum("n,n,nk->k", found.dA, found.u[:, i], found.potentials) * 3.0 / (4.0 * np.pi)
        assert np.linalg.norm(c) == pytest.approx(1.0, abs=1e-13)
        np.testing.assert_allclose(found.potentials @ c, found.u[:, i], atol=1e-13)
        np.testing.assert_allclose(found.fields @ c, np.cross(np.eye(3)[i], found.u), atol=1e-12)


@pytest.mark.parametrize("a", [1e-3, 0.3, 0.7, 0.99, 1.0])
def test_a_symmetry_turns_around_in_2_pi(a):
    """Beyond a = sqrt(3)/2, too, where there is no embedding."""
    found = rotations(KerrNewmanHorizon(1.0, a), 24, axisymmetric=True)
    assert found.shears[0] < 1e-9
    assert found.shears[1] == pytest.approx(found.shears[2], rel=1e-8)
    assert found.shears[1] > 0.25 * a**2
    c = found.dA @ (found.u[:, 2:] * found.potentials)
    c /= np.linalg.norm(c)
    assert found.shear(c) < 1e-9
    # (r_+^2 + a^2) cos(theta), in units of A / 4 pi
    np.testing.assert_allclose(found.potentials @ c, found.u[:, 2], atol=1e-9)
    np.testing.assert_allclose(found.fields @ c, np.cross((0, 0, 1), found.u), atol=1e-8)


def test_fewer_orders_do_where_the_metric_is_symmetric():
    sphere = KerrNewmanSphere(2.0, 1.0, 0.9)
    few, all_ = (rotations(sphere, 12, symmetric).shears for symmetric in (True, False))
    np.testing.assert_allclose(few, all_, atol=1e-7)


def test_they_belong_to_the_surface_and_not_to_the_directions():
    """The same ellipsoid from its center, from another point, and as the image of a sphere."""
    axes = (1.3, 1.15, 1.0)
    metrics = [ellipsoid(c, axes).metric(FLAT) for c in ((0, 0, 0), (0.1, -0.1, 0.2))]
    shears = [rotations(metric, 14, False).shears for metric in (*metrics, linear(np.diag(axes)))]
    assert 0.05 < shears[2][0] < shears[2][1] < shears[2][2] < 0.3
    for shear in shears[:2]:
        np.testing.assert_allclose(shear, shears[2], atol=1e-5)


def test_the_shear_of_a_slightly_oblate_spheroid():
    """To first order in e, q = q0 - 2 e dz^2, and the shear of the rotation about y is 2 e dx dz."""
    e = 1e-4
    found = rotations(linear(np.diag((1.0, 1.0, 1.0 - e))), 10, axisymmetric=True)
    u, dA = found.u, found.dA
    P = np.eye(3) - u[:, :, None] * u[:, None, :]
    dx, dz = P[:, 0], P[:, 2]
    tensor = e * (dx[:, :, None] * dz[:, None, :] + dz[:, :, None] * dx[:, None, :])
    tensor -= 0.5 * np.einsum("nii->n", tensor)[:, None, None] * P
    phi2 = np.sum(np.cross((0, 1, 0), u) ** 2, axis=1)
    upper = np.sqrt(dA @ np.einsum("nij,nij->n", tensor, tensor) / (dA @ phi2))
    # The least is smaller: potentials of degree three may help.
    assert 0.1 * upper < found.shears[1] <= upper * (1.0 + 1e-3)
    assert found.shears[0] < 1e-13


def test_twists_of_a_long_surface_are_left_out():
    found = rotations(linear(np.diag((1.0, 1.0, 3.0))), 40, axisymmetric=True)
    assert found.shears[0] < 1e-4
    assert found.shears[1] == pytest.approx(found.shears[2], rel=1e-9)


def test_a_conformally_flat_slice_knows_no_more_symmetry():
    egg = StarSurface.from_angles(lambda theta, phi: 2.0 + 0.1 * np.cos(theta) ** 3)
    found = rotations(egg.metric(IsotropicSchwarzschild(1.0)), 16, axisymmetric=False)
    assert found.shears[0] < 1e-9 < 1e-3 < found.shears[1]
