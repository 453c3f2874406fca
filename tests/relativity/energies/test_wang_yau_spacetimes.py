"""The Wang-Yau energy in curved spacetimes: Kerr's, a star, one surface in two slices."""

from dataclasses import replace

import numpy as np
import pytest

from isoembed.errors import NotEmbedded
from isoembed.relativity import (
    AnalyticCallable,
    KerrNewmanSphere,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    TimeFunction,
    embed_surface,
    wang_yau,
)
from isoembed.relativity.energies import wang_yau_search
from isoembed.smooth import embed_smooth
from spacelike import nothing, static

EAST = np.sqrt(4.0 * np.pi / 3.0)  # times the harmonic of degree 1 is z


@pytest.fixture
def few_harmonics(monkeypatch):
    """Fewer harmonics of X than by default, which are enough here."""
    monkeypatch.setattr(wang_yau_search, "DEGREES", (12, 12))


@pytest.mark.usefixtures("few_harmonics")
def test_one_sphere_in_two_slices():
    data, embedding = static()
    falling = StarSurface.sphere((0, 0, 0), 4.0).data(PainleveGullstrand(1.0))
    waving = TimeFunction.of(lambda u: 2.0 * u[:, 2] + 0.5 * u[:, 0] * u[:, 1], 2)
    for tau in (waving, None):
        one, other = (wang_yau(d, tau, embedding=embedding).energy.value for d in (data, falling))
        assert one == pytest.approx(other, rel=1e-13)


@pytest.mark.slow
@pytest.mark.usefixtures("few_harmonics")
def test_constant_density_star():
    rho, ratios = 0.01, []
    kappa = 8.0 * np.pi * rho / 3.0

    def gamma(x):
        stretch = kappa / (1.0 - kappa * np.einsum("ni,ni->n", x, x))
        return np.eye(3) + stretch[:, None, None] * x[:, :, None] * x[:, None, :]

    star = AnalyticCallable(gamma)
    for r in (2.0, 0.1):
        data = StarSurface.sphere((0, 0, 0), r).data(star)
        found = wang_yau(data, embedding=embed_smooth(data.metric, vertices=100)).energy.value
        assert found == pytest.approx(r * (1.0 - np.sqrt(1.0 - kappa * r**2)), abs=1e-14 * r)
        ratios.append(found / (4.0 * np.pi * rho * r**3 / 3.0) - 1.0)
    # Small spheres: the energy density times the volume, and next kappa r^2 / 4 of it.
    np.testing.assert_allclose(ratios[1], 0.25 * kappa * 0.1**2, rtol=1e-3)


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.parametrize("a", [0.5, 0.8])
def test_kerr(a):
    data = KerrNewmanSphere(3.0, 1.0, a).data()
    surface = embed_surface(data, vertices=100)
    found = wang_yau(data, "optimal", embedding=surface.embedding, degrees=(2, 4))
    assert found.gradient < 1e-10
    assert found.least_second_derivative > 1e-3
    np.testing.assert_allclose(found.tau.coefficients, 0.0, atol=1e-9)
    assert found.energy.value == pytest.approx(surface.energies.brown_york.value, rel=1e-11)
    assert found.energy.value == pytest.approx(surface.energies.liu_yau.value, rel=1e-11)


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.slow
def test_kerr_in_two_slices():
    # r = const is one surface in both, turned about the axis; p and the connection differ.
    hole, r, a = KerrSchild(1.0, (0, 0, 0.5)), 4.0, 0.5
    R = hole.spheroid(r)

    def tau(z, x):
        return 1.5 * z + 0.8 * x + 0.3 * z**2

    one = wang_yau(KerrNewmanSphere(r, 1.0, a).data(), TimeFunction.of(lambda u: tau(u[:, 2], u[:, 0]), 2))
    data = StarSurface.from_radius(R).data(hole)
    same = TimeFunction.of(lambda u: tau(R(u) * u[:, 2] / r, R(u) * u[:, 0] / np.hypot(r, a)), 12)
    other = wang_yau(data, same)
    assert one.energy.value == pytest.approx(other.energy.value, rel=1e-12)
    wrong = wang_yau(replace(data, normal_momentum=nothing), same)
    assert wrong.energy.value != pytest.approx(one.energy.value, rel=1e-6)


@pytest.mark.slow
def test_a_surface_that_only_embeds_with_time():
    """r = 1.5 of spin .95, below the radius from which it embeds in R^3 (Miller, Ray, Wang & Yau 2018)."""
    data = KerrNewmanSphere(1.5, 1.0, 0.95).data()
    for tau in (None, "optimal"):
        with pytest.raises(NotEmbedded, match="no surface of revolution has this metric"):
            wang_yau(data, tau)
    found = wang_yau(data, lambda u: 1.2 * u[:, 2])
    assert found.admissible > 0.0 and found.energy.error < 1e-6
    assert found.embedding.least_curvature > 0.0
