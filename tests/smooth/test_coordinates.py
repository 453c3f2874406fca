"""Coordinates that fit: what they gain, where there is nothing to gain, and what does not count."""

from functools import cache

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions, gauss_rule, hull_faces
from isoembed.smooth import Harmonics
from isoembed.smooth.coordinates import fitting_coordinates


def ellipsoid(axes, center=(0.0, 0.0, 0.0)):
    """X(u) as seen from a center inside."""
    D, c = np.array(axes) ** -2.0, np.array(center)

    def points(u):
        a, b = u**2 @ D, u @ (D * c)
        return (-b + np.sqrt(b**2 - a * (c @ (D * c) - 1.0)))[:, None] / a[:, None] * u

    return points


def bumpy(u):
    harmonics = Harmonics(10, 10)
    c = 0.02 * np.random.default_rng(1).normal(size=harmonics.size)
    return (1.0 + harmonics.values(u) @ c)[:, None] * u


@cache
def mesh(n=600):
    u = fibonacci_directions(n)
    return u, hull_faces(u)


def noisy(points, n=600):
    """Vertices that are off by some permille, as those of an embedded polyhedron are."""
    x = points(mesh(n)[0])
    return x + 1e-3 * np.random.default_rng(0).normal(size=x.shape) * np.linalg.norm(x, axis=1).mean()


def highest(points, degree):
    """The largest coefficient of X of this degree, or the one below, over all."""
    harmonics = Harmonics(degree, degree)
    u, weights = gauss_rule(degree + 40, 2 * degree + 80)
    C = harmonics.values(u).T @ (weights[:, None] * points(u))
    return np.abs(C[harmonics.labels[0] >= degree - 1]).max() / np.abs(C).max()


@pytest.mark.parametrize(
    ("axes", "center"),
    [
        ((3.0, 2.0, 1.0), (0.0, 0.0, 0.0)),
        ((1.0, 1.0, 1.0), (0.4, 0.3, -0.5)),
        ((3.0, 2.0, 1.0), (1.2, 0.6, 0.3)),
    ],
)
def test_ellipsoids_as_radii(axes, center):
    points = ellipsoid(axes, center)
    F = fitting_coordinates(*mesh(), noisy(points))
    assert F.harmonics.degree == 1
    before, after = highest(points, 12), highest(lambda v: points(F.forward(v)), 12)
    assert after < 1e-4 and after < 0.05 * before


def test_units_rotations_and_places_do_not_count():
    u, faces = mesh()
    x = noisy(ellipsoid((3.0, 2.0, 1.0)))
    R = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    one = fitting_coordinates(u, faces, x)
    other = fitting_coordinates(u, faces, 1e6 * (x @ R + [5.0, -3.0, 0.0]))
    np.testing.assert_allclose(one.forward(u), other.forward(u), atol=1e-7)


@pytest.mark.parametrize(
    "points", [lambda u: u, lambda u: u * [3.0, 2.0, 1.0], ellipsoid((1.3, 1.1, 1.0)), bumpy]
)
def test_nothing_is_gained(points):
    assert fitting_coordinates(*mesh(), noisy(points)) is None
