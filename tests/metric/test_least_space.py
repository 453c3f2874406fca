"""The least curvature at which lengths are a convex metric."""

import numpy as np
import pytest

import isoembed
from isoembed.gallery import Ergosphere, KerrHorizon, Sphere, triangulate
from isoembed.metric.curvature import deficits
from isoembed.metric.least_space import least_convex_space
from isoembed.smooth.geodesics import geodesic_lengths
from isoembed.smooth.two_metric import AngleMetric


def kerr(spin, n):
    """Lengths on the horizon, which for large spins has none in R^3."""
    r = 1 + np.sqrt(1 - spin**2)

    def components(theta, phi):
        sigma = r**2 + (spin * np.cos(theta)) ** 2
        return sigma, 0.0, ((r**2 + spin**2) * np.sin(theta)) ** 2 / sigma

    u, faces = triangulate(Sphere(), n)
    a, b = isoembed.Triangulation(faces).edges.T
    return isoembed.PolyhedralMetric(faces, geodesic_lengths(AngleMetric(components), u[a], u[b]))


def test_kerr_horizon_needs_its_curvature_at_the_poles():
    spin = 0.95
    r = 1 + np.sqrt(1 - spin**2)
    pole = (r**2 - 3 * spin**2) / (r**2 + spin**2) ** 2
    off = [least_convex_space(kerr(spin, n)).curvature - pole for n in (200, 800)]
    assert abs(off[1]) < 0.05 * abs(pole)
    assert off[0] / off[1] > 3


@pytest.mark.parametrize("scale", [1e-100, 1.0, 1e9])
def test_least_deficit_is_zero(scale):
    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ergosphere(epsilon=0.3), 200)).scaled(scale)
    space = least_convex_space(metric)
    there = isoembed.PolyhedralMetric.on(metric.triangulation, metric.lengths, space)
    assert deficits(metric).min() < -0.01
    assert abs(deficits(there).min()) < 1e-12


def test_convex_metric_needs_no_curvature():
    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(KerrHorizon(spin=0.5), 100))
    assert least_convex_space(metric) == isoembed.Euclidean()
    curved = isoembed.PolyhedralMetric.on(metric.triangulation, metric.lengths, isoembed.Hyperbolic(3.0))
    assert least_convex_space(curved) == isoembed.Euclidean()


def test_flat_vertices_of_a_rotated_cube_ask_for_no_curvature():
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    squares = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    inside = 0.31 * corners[squares[:, 0]] + 0.19 * corners[squares[:, 1]] + 0.5 * corners[squares[:, 2]]
    faces = [[q[c], q[(c + 1) % 4], 8 + f] for f, q in enumerate(squares) for c in range(4)]
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    metric = isoembed.PolyhedralMetric.from_mesh(np.concatenate([corners, inside]) @ turn, faces)
    assert least_convex_space(metric) == isoembed.Euclidean()
