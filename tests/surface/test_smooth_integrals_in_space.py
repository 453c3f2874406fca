"""Integrals over smooth surfaces in hyperbolic and spherical space: closed forms, and fourth order."""

from functools import cache

import numpy as np
import pytest

from isoembed.gallery import KerrHorizon, Sphere, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.smooth import triangulate_metric
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.two_metric import AngleMetric
from isoembed.space import Space
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smooth_integrals import SmoothIntegrals
from isoembed.surface.surface import Surface

CURVATURES = (-0.5, 0.3)


def components(theta, _):
    round_ = 1.0 + 0.1 * np.cos(theta)
    return round_ * (1.0 + 0.2 * np.sin(theta) ** 2), 0.0, round_ * np.sin(theta) ** 2


EGG = AngleMetric(components)


@cache
def egg(n, k):
    """A mesh of the metric, its surface of revolution in space, and that surface's points."""
    mesh = triangulate_metric(EGG, n)
    surface = AxisymmetricEmbedding.of(EGG, space=Space(k))
    return mesh, surface, surface.points(mesh.directions)


@pytest.mark.parametrize("k", CURVATURES)
def test_spheres(k):
    u, faces = triangulate(Sphere(), 300)
    space, r = Space(k), 1.2
    found = SmoothIntegrals(Triangulation(faces), float(space.sn(r)) * u, "chord", space)
    sn, cs = float(space.sn(r)), float(space.cs(r))
    volume = 2.0 * np.pi / k * (r - sn * cs)
    for estimate, exact in (
        (found.area, 4.0 * np.pi * sn**2),
        (found.integrated_mean_curvature, 4.0 * np.pi * sn * cs),
        (found.volume, volume),
        (found.integral(u[:, 0] ** 2), 4.0 * np.pi / 3.0 * sn**2),
    ):
        assert abs(estimate.value - exact) < min(estimate.error, 3e-3 * exact)


@pytest.mark.parametrize("k", CURVATURES)
def test_chords_to_fourth_order(k):
    misses = []
    for n in (200, 800):
        mesh, surface, x = egg(n, k)
        found = SmoothIntegrals(mesh.metric.triangulation, x, "chord", Space(k))
        imc, area = found.integrated_mean_curvature, found.area
        assert abs(imc.value - surface.integrated_mean_curvature) < imc.error
        assert abs(area.value - surface.area) < area.error
        misses.append(
            np.abs([imc.value / surface.integrated_mean_curvature - 1, area.value / surface.area - 1])
        )
    assert (misses[1] < misses[0] / 8.0).all() and misses[1].max() < 1e-4


@pytest.mark.parametrize("k", CURVATURES)
def test_geodesics_to_fourth_order(k):
    misses = []
    for n in (200, 800):
        mesh, surface, x = egg(n, k)
        t, lengths, space = mesh.metric.triangulation, mesh.metric.lengths, Space(k)
        for _ in range(5):
            x = x - LengthSystem(t, space=space).step(x, lengths, length_residuals(t, x, lengths, space))
        assert np.abs(length_residuals(t, x, lengths, space)).max() < 1e-12
        found = SmoothIntegrals.of(Surface(t, x, space), "geodesic")
        imc, area = found.integrated_mean_curvature, found.area
        assert abs(imc.value - surface.integrated_mean_curvature) < imc.error
        assert abs(area.value - surface.area) < area.error
        misses.append(
            np.abs([imc.value / surface.integrated_mean_curvature - 1, area.value / surface.area - 1])
        )
    assert (misses[1] < misses[0] / 8.0).all() and misses[1].max() < 5e-6


def test_the_curvature_tends_to_zero():
    vertices, faces = triangulate(KerrHorizon(spin=0.8), 200)
    t, values = Triangulation(faces), vertices[:, 2] ** 2
    for lengths in ("chord", "geodesic"):
        flat = SmoothIntegrals(t, vertices, lengths)
        near = SmoothIntegrals(t, vertices, lengths, Space(1e-9))
        for one, other in (
            (flat.integrated_mean_curvature, near.integrated_mean_curvature),
            (flat.area, near.area),
            (flat.integral(values), near.integral(values)),
        ):
            assert other.value == pytest.approx(one.value, rel=1e-7)
            assert other.error == pytest.approx(one.error, rel=1e-5)
