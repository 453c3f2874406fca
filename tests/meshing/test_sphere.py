"""Points on the unit sphere: the lattice, the rule and the hull."""

import numpy as np

from isoembed.mesh.triangulation import Triangulation
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule, hull_faces
from isoembed.smooth.harmonics import Harmonics


def test_the_lattice_is_even():
    u = fibonacci_directions(2000)
    np.testing.assert_allclose(np.linalg.norm(u, axis=1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(u.mean(axis=0), 0.0, atol=2e-3)
    np.testing.assert_allclose(u.T @ u / 2000, np.eye(3) / 3, atol=2e-3)


def test_the_rule_is_exact_below_its_degree_and_not_beyond():
    n, around = 6, 9
    u, w = gauss_rule(n, around)
    degrees, orders = Harmonics(2 * n, 2 * n).labels
    integrals = w @ Harmonics(2 * n, 2 * n).values(u)
    exact = np.where(degrees == 0, np.sqrt(4.0 * np.pi), 0.0)
    inside = (degrees < 2 * n) & (np.abs(orders) < around)
    np.testing.assert_allclose(integrals[inside], exact[inside], atol=1e-13)
    assert np.abs(integrals - exact)[~inside].max() > 1e-3


def test_long_rules_have_the_accuracy_of_short_ones():
    for n in (768, 769):
        u, w = gauss_rule(n, 4)
        assert abs(w.sum() / (4 * np.pi) - 1) < 1e-13
        assert abs(w @ u[:, 2] ** 20 / (4 * np.pi) * 21 - 1) < 1e-11


def test_the_hull_looks_outward():
    u = fibonacci_directions(100)
    faces = hull_faces(u)
    assert Triangulation(faces).n_vertices == 100
    assert (np.linalg.det(u[faces]) > 0).all()
