"""What surfaces have in common, for a surface that is given by a formula alone."""

from collections.abc import Iterator

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import area_density

U = fibonacci_directions(50)
HOLE = KerrSchild(1.0, (0.3, 0.5, -0.6))


class Linear(Surface):
    """The ellipsoid X = A u + c, whose second derivatives on the sphere are - A u times its metric."""

    harmonics, misfit, deviations, notes, mean_radius = Harmonics(1, 1), 0.0, None, (), 2.5

    def __init__(self, A, center):
        self.A, self.center = np.array(A), center

    def jet(self, u):
        x = u @ self.A.T
        second = -x[:, :, None, None] * np.eye(3)
        first = np.broadcast_to(self.A, (len(u), 3, 3))
        return Jet.of_tensors(u, x + np.array(self.center), first, second)

    def deviating(self, u) -> Iterator[Jet]:
        yield self.jet(u)


A = np.array([[3.0, 0.2, 0.0], [0.1, 2.0, -0.3], [0.0, 0.4, 2.5]])
CENTER = (0.1, -0.2, 0.3)
ELLIPSOID = Linear(A, CENTER)


def other(kind):
    """The same surface in harmonics."""
    if kind == "mapped":
        return MappedSurface.from_map(ELLIPSOID.points, CENTER)
    inverse = np.linalg.inv(A)
    return StarSurface.from_radius(lambda u: 1.0 / np.linalg.norm(u @ inverse.T, axis=1), CENTER)


@pytest.mark.parametrize("kind", ["mapped", "star"])
def test_other_surfaces_agree_with_the_formula(kind):
    surface = other(kind)
    directions = U
    if kind == "star":
        directions = U @ A.T
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for quantity in ("mean_curvature", "momentum", "expansion"):
        expected = getattr(ELLIPSOID, quantity)(HOLE, U)
        np.testing.assert_allclose(getattr(surface, quantity)(HOLE, directions), expected, atol=1e-10)
    one, two = (s.data(HOLE, axis=(0, 0, 2)) for s in (ELLIPSOID, surface))
    assert two.angular_momentum == pytest.approx(one.angular_momentum, abs=1e-12)
    np.testing.assert_allclose(two.torque(directions), one.torque(U), atol=1e-11)


def test_mean_curvature_is_that_of_the_quadric():
    flat = AnalyticCallable(lambda x: np.eye(3) + 0.0 * x[:, :1, None])
    # of |B (x - c)| = 1: div of the unit normal
    B = np.linalg.inv(A)
    Q = B.T @ B
    gradient = (ELLIPSOID.points(U) - CENTER) @ Q
    size = np.linalg.norm(gradient, axis=1)
    expected = np.trace(Q) / size - np.einsum("ni,ij,nj->n", gradient, Q, gradient) / size**3
    np.testing.assert_allclose(ELLIPSOID.mean_curvature(flat, U), expected, rtol=1e-13)


def test_torques_integrate_to_the_spin():
    u, weights = gauss_rule(24, 48)
    around = Linear(A, (0.0, 0.0, 0.0))
    local = around.local_geometry(HOLE, u)
    J = weights * area_density(local.q) @ local.torque(np.zeros(3)) / (8 * np.pi)
    spin = np.array(HOLE.spin)
    assert J @ spin == pytest.approx(spin @ spin, rel=1e-12)
    assert around.angular_momentum(HOLE, 7.0 * spin) == pytest.approx(np.linalg.norm(spin), rel=1e-12)


@pytest.mark.parametrize("axis", [(0, 0, 0), (0, 1), "z", (np.nan, 0, 1)])
def test_refusals(axis):
    with pytest.raises(InvalidParameter, match="the axis must"):
        ELLIPSOID.angular_momentum(HOLE, axis)
    with pytest.raises(InvalidParameter, match=r"directions must be unit vectors \(n, 3\)"):
        ELLIPSOID.points(np.ones(3))
