"""The Wang-Yau energy with (anti-)de Sitter space for reference, tau = 0: closed forms, limits, refusals."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity import (
    KerrDeSitterSphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    chen_wang_yau,
    embed_surface,
    embedded_report,
    energy_table,
    wang_yau,
)
from isoembed.smooth.sphere_map import SphereMap
from isoembed.space import Hyperbolic, Space, Spherical


def energy(data, curvature):
    return chen_wang_yau(data, embed_surface(data, space=Space(curvature)).embedding)


@pytest.mark.parametrize("constant", [-3.0, -0.03, 0.03])
def test_schwarzschild(constant):
    r, k = 3.0, constant / 3.0
    data = KerrDeSitterSphere(r, 1.0, 0.0, constant).data()
    found = energy(data, k)
    far, near = sqrt(1.0 - k * r * r), sqrt(1.0 - 2.0 / r - k * r * r)
    assert found.energy.value == pytest.approx(r * far * (far - near), rel=1e-12)
    assert found.energy.error < 1e-10 and found.gradient == 0.0 and not found.notes
    np.testing.assert_allclose(found.center, 0.0, atol=1e-11)


@pytest.mark.parametrize("constant", [-1.0, 0.05])
def test_horizons_without_spin_have_twice_their_mass(constant):
    data = KerrDeSitterSphere.horizon(1.0, 0.0, constant).data()
    found = energy(data, constant / 3.0)  # r V^2 = 2 m where r (V^2) - 2 m = 0
    assert found.energy.value == pytest.approx(2.0, rel=1e-12) and found.gradient is None


def test_large_spheres_of_kerr_anti_de_sitter_have_the_conserved_mass():
    # E = m / Xi^2 + O(r^-3)
    misses = []
    for r in (8.0, 16.0):
        sphere = KerrDeSitterSphere(r, 1.0, 0.5, -3.0)
        found = energy(sphere.data(), -1.0)
        misses.append(found.energy.value - sphere.physical_mass)
        assert found.gradient < 1e-10 and not found.notes
    assert misses[0] == pytest.approx(8.0 * misses[1], rel=0.05)
    assert 0.0 < misses[1] < 1e-3


@pytest.mark.slow
def test_the_curvature_tends_to_zero():
    # In Euclidean space V = 1, and the energy is that of Kijowski, Liu and Yau.
    data = KerrNewmanSphere(3.0, spin=0.8).data()
    flat = embed_surface(data).energies.liu_yau.value
    assert chen_wang_yau(data, embed_surface(data).embedding).energy.value == pytest.approx(flat, rel=1e-12)
    found = [energy(data, k).energy.value for k in (-1e-4, 1e-4, 2e-4)]
    assert found[1] - flat == pytest.approx(flat - found[0], rel=2e-3)
    assert found[2] - flat == pytest.approx(2.0 * (found[1] - flat), rel=2e-3)


def lopsided(factor):
    """A round sphere in a slice in which k0 - k depends on the height."""
    sphere = KerrNewmanSphere(2.5, 0.5)
    return SurfaceData(
        sphere, mean_curvature=lambda u: (1.0 - factor * (1.0 + 0.6 * u[:, 2])) * sphere.mean_curvature(u)
    )


@pytest.mark.parametrize("k", [-0.1, 0.05])
def test_observers_at_rest_are_where_the_energy_is_stationary(k):
    data = lopsided(0.2)
    space, surface = Space(k), embed_surface(data, space=Space(k))
    found = chen_wang_yau(data, surface.embedding)
    assert found.center[2] > 0.05
    p_0, p = found.momentum[0], found.momentum[1:]

    def seen(z):  # w_a p_0 + k a . p
        a = np.array([0.0, 0.0, z])
        return float(space.heights(a)) * p_0 + k * a @ p

    assert seen(found.center[2]) == pytest.approx(found.energy.value, rel=1e-12)
    for z in found.center[2] + np.array([-0.1, 0.1]):
        assert (seen(z) > found.energy.value) == (k < 0)


def test_it_does_not_depend_on_directions():
    data = KerrDeSitterSphere(3.0, 1.0, 0.5, -0.3).data()
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])
    tilted = data.in_coordinates(SphereMap.linear(turn))
    upright, other = energy(data, -0.1), energy(tilted, -0.1)
    assert other.energy.value == pytest.approx(upright.energy.value, rel=1e-10)
    assert other.gradient < 1e-10


def test_it_does_not_depend_on_the_slice():
    slice_ = KerrSchild(1.0, (0.0, 0.0, 0.8))
    moving = StarSurface.from_radius(slice_.spheroid(3.0)).data(slice_)
    found, static = energy(moving, -0.05), energy(KerrNewmanSphere(3.0, 1.0, 0.8).data(), -0.05)
    assert found.energy.value == pytest.approx(static.energy.value, rel=1e-11)
    assert found.gradient < 1e-10  # where p is not 0, K(., n) alone has a divergence
    alone = replace(moving, momentum=lambda u: np.full(len(u), 1e-9))
    assert energy(alone, -0.05).gradient > 1e-3


def test_where_tau_is_not_critical_it_is_said():
    data = KerrDeSitterSphere(3.0, 1.0, 0.0, -0.3).data()
    j = replace(data, normal_momentum=lambda u: 0.1 * (np.array([0.0, 0.0, 1.0]) - u[:, 2:] * u))
    found = energy(j, -0.1)
    assert found.gradient > 1e-3 and "tau = 0 is not critical" in found.notes[0]
    assert found.energy.value == pytest.approx(energy(data, -0.1).energy.value, rel=1e-14)


def test_reports():
    data = KerrDeSitterSphere(3.0, 1.0, 0.5, -0.3).data()
    surface = embed_surface(data, space=Hyperbolic(0.1))
    report = embedded_report(surface, surface.wang_yau)
    assert report["wang_yau"] == chen_wang_yau(data, surface.embedding).energy.value
    assert report["rest_frame"]["momentum"][0] == pytest.approx(report["wang_yau"], rel=1e-12)
    assert report["space"] == {"name": "hyperbolic", "curvature": -0.1}
    assert "int V" in report["conventions"]["wang_yau"]
    assert "in hyperbolic space of curvature -0.1\n" in energy_table(report)


def test_refusals():
    data = KerrNewmanSphere(3.0).data()
    surface = embed_surface(data, space=Spherical(0.01)).embedding
    with pytest.raises(InvalidParameter, match="the reference here is Minkowski space"):
        wang_yau(data, embedding=surface)
    with pytest.raises(InvalidParameter, match="k is not given"):
        chen_wang_yau(SurfaceData(data.metric), surface)
    trapped = replace(data, mean_curvature=lambda u: u[:, 2])
    with pytest.raises(InvalidParameter, match="no Kijowski-Liu-Yau energy"):
        chen_wang_yau(trapped, surface)
    with pytest.raises(InvalidParameter, match="not a Space"):
        embed_surface(KerrNewmanHorizon().data(), space="spherical")
    horizon = replace(data, mean_curvature=lambda u: 0.7 + 30.0 * np.maximum(u[:, 2], 0.0) ** 4)
    with pytest.raises(InvalidParameter, match="not timelike"):
        chen_wang_yau(horizon, embed_surface(data, space=Hyperbolic(1.0)).embedding)
