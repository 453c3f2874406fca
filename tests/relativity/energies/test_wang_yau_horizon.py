"""The Wang-Yau energy of surfaces that tend to a horizon (arXiv:2406.10751), and of the horizon."""

from functools import cache

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.relativity import (
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    embed_surface,
    embedded_report,
    energy_table,
    wang_yau,
)
from isoembed.smooth import PulledBack, embed_smooth
from spacelike import round_sphere


@pytest.mark.parametrize("distance", [1e-3, 1e-12])
def test_spheres_of_schwarzschild(distance):
    r = 2.0 * (1.0 + distance)
    data = round_sphere(r)
    found = wang_yau(data, "optimal", embedding=embed_smooth(data.metric, vertices=100), degrees=(2,))
    assert found.energy.value == pytest.approx(r * (1.0 - np.sqrt(1.0 - 2.0 / r)), rel=1e-13)
    assert found.least_second_derivative > 0.0
    np.testing.assert_array_equal(found.tau.coefficients, 0.0)


@cache
def horizon():
    return embed_surface(KerrNewmanHorizon(1.0, 0.5).data(), vertices=100)


def outside(distance):
    """A surface without symmetry in a slice with K_ij, near the horizon of spin .5."""
    hole = KerrSchild(1.0, (0.3, 0.0, 0.4))
    R = hole.spheroid(hole.horizon)
    surface = StarSurface.from_radius(
        lambda u: R(u) * (1.0 + distance * (1.0 + 0.1 * u[:, 0] * u[:, 2] + 0.15 * u[:, 1]))
    )
    data = surface.data(hole)
    return data, embed_surface(data, vertices=100)


@pytest.mark.slow
def test_the_least_energy_tends_to_that_of_the_horizon():
    limit = wang_yau(horizon().data, "optimal", embedding=horizon().embedding)
    assert limit.energy.value == pytest.approx(1.933768125368, rel=1e-12)
    assert limit.energy == horizon().energies.liu_yau
    missing, steep = [], []
    for distance in (1e-4, 1e-7):
        data, surface = outside(distance)
        found = wang_yau(data, "optimal", embedding=surface.embedding, degrees=(2, 4))
        assert found.energy.value < surface.energies.liu_yau.value
        assert found.least_second_derivative > 0.0 and not found.notes
        missing.append(limit.energy.value - found.energy.value)
        steep.append(np.abs(found.tau.coefficients).max())
    # |H| and with it tau fall like the root of the distance.
    assert missing[0] / missing[1] == pytest.approx(np.sqrt(1000.0), rel=0.02) and missing[1] > 0.0
    assert steep[0] / steep[1] == pytest.approx(np.sqrt(1000.0), rel=0.02)
    assert missing[1] < 2e-3 and steep[1] < 1e-3


@pytest.mark.slow
def test_a_steep_time_costs_more_and_more():
    energies = []
    for distance in (1e-5, 1e-7):
        data = round_sphere(2.0 * (1.0 + distance))
        embedding = embed_smooth(data.metric, vertices=100)
        energies.append(wang_yau(data, lambda u: 0.2 * u[:, 2], embedding=embedding).energy.value)
    # Like the logarithm of |H|: by int |lap tau| dA / 8 pi = .1 for each factor e of |H|.
    np.testing.assert_allclose(np.diff(energies), 0.1 * np.log(10.0), rtol=0.01)


def test_a_horizon():
    surface = horizon()
    for tau in (None, "optimal", lambda u: np.zeros(len(u))):
        found = wang_yau(surface.data, tau, embedding=surface.embedding)
        assert found.energy == surface.energies.liu_yau
        assert "limit int k0 dA / 8 pi" in found.notes[0] and len(found.notes) == 1
    with pytest.raises(InvalidParameter, match="grows without bound for every tau but 0"):
        wang_yau(surface.data, lambda u: u[:, 2], embedding=surface.embedding)
    report = embedded_report(surface, surface.wang_yau)
    assert report["wang_yau"] == report["liu_yau"]
    assert report["minimum"]["least_second_derivative"] is None


def test_a_horizon_with_negative_curvature_is_not_admissible():
    def slope(u):
        # Of (0.6 (1 + z^2) x, 0.6 (1 + z^2) y, 1.6 z), which has a waist.
        D = np.zeros((len(u), 3, 3))
        D[:, 0, 0] = D[:, 1, 1] = 0.6 * (1.0 + u[:, 2] ** 2)
        D[:, :2, 2] = 1.2 * u[:, 2:] * u[:, :2]
        D[:, 2, 2] = 1.6
        return D

    surface = embed_surface(SurfaceData(PulledBack(slope), marginal=True))
    found = surface.wang_yau
    assert found.admissible < 0.0 and "tau is not admissible: K + det D^2 tau" in found.notes[1]
    report = embedded_report(surface, found)
    assert report["wang_yau_admissible"] is False
    text = energy_table(report)
    assert "\nE(tau), tau not admissible " in text and "Wang-Yau energy  " not in text


@pytest.mark.slow
def test_a_surface_near_a_horizon_that_does_not_embed_has_no_energy():
    data = KerrNewmanSphere(1.45, 1.0, 0.9).data()  # beyond sqrt(3) / 2
    with pytest.raises(NotEmbedded, match=r"no surface of revolution has this metric for theta < 0\.521"):
        wang_yau(data, "optimal")
