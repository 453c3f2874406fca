"""Energies of surfaces whose embedding has coordinates of its own: tilted axes, poor directions."""

from functools import cache

import numpy as np
import pytest

from isoembed.errors import NotEmbedded
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrSchild, StarSurface, SurfaceData, TimeFunction, embed_surface, wang_yau
from isoembed.smooth import Harmonics, PulledBack, SphereMap

U = fibonacci_directions(40)
TILTED = np.array([0.0, 0.6, 0.8])


@cache
def around_kerr(tilted):
    slice_ = KerrSchild(1.0, tuple(0.5 * (TILTED if tilted else np.array([0.0, 0.0, 1.0]))))
    return embed_surface(StarSurface.from_radius(slice_.spheroid(4.0)).data(slice_), vertices=200)


def ellipsoid():
    """The one with semi-axes 3, 2 and 1 in flat space, as r(u): its energies are 0."""
    D = np.array([3.0, 2.0, 1.0]) ** -2

    def radius(u):
        return (u**2 @ D) ** -0.5

    def differential(u):
        r = radius(u)
        slope = -(r**3)[:, None] * u * D
        slope -= (slope * u).sum(axis=1)[:, None] * u
        return u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)

    def mean_curvature(u):
        g = radius(u)[:, None] * u * D
        square = np.einsum("ni,ni->n", g, g)
        return (D.sum() - g**2 @ D / square) / np.sqrt(square)

    return SurfaceData(
        PulledBack(differential), mean_curvature, shape=lambda u: radius(u)[:, None] * u, name="ellipsoid"
    )


def test_energies_of_a_tilted_surface():
    upright, tilted = around_kerr(False), around_kerr(True)
    assert tilted.embedding.coordinates is not None
    for name in ("area", "hawking", "brown_york", "liu_yau"):
        one, other = getattr(upright.energies, name), getattr(tilted.energies, name)
        assert abs(one.value - other.value) <= 1e-13 + 2e-14 * one.value


def test_a_tilted_time_function():
    upright, tilted = around_kerr(False), around_kerr(True)

    def tau(axis):
        return lambda u: 0.5 * (u @ axis) ** 2 + 0.3 * u @ axis

    one = wang_yau(upright.data, tau([0.0, 0.0, 1.0]), embedding=upright.embedding)
    other = wang_yau(tilted.data, tau(TILTED), embedding=tilted.embedding)
    assert abs(one.energy.value - other.energy.value) < 1e-13
    np.testing.assert_allclose(other.tau.values(U) - other.tau.values(TILTED[None]), tau(TILTED)(U) - 0.8)
    assert other.tau.coordinates is None and not other.notes
    assert other.embedding.strain(U).max() < 1e-10


def test_poor_directions():
    data = ellipsoid()
    surface = embed_surface(data, vertices=300)
    assert surface.embedding.coordinates is not None and surface.embedding.coordinates.rotation is None
    energies = surface.energies
    assert abs(energies.brown_york.value) <= energies.brown_york.error < 1e-10
    mesh = surface.mesh(300)
    np.testing.assert_allclose(mesh["vertices"], mesh["slice_coordinates"], atol=1e-9)
    np.testing.assert_allclose(2.0 * mesh["mean_curvature"], mesh["k"], rtol=1e-8)


@pytest.mark.slow
def test_the_wang_yau_energy_in_poor_directions():
    data = ellipsoid()
    surface = embed_surface(data)
    found = wang_yau(data, tau=None, embedding=surface.embedding)
    assert abs(found.energy.value) <= found.energy.error < 1e-9
    assert found.tau.coordinates is surface.embedding.coordinates


def test_time_functions_in_other_directions():
    coordinates = SphereMap.linear(np.diag([1.5, 1.2, 1.0]))
    tau = TimeFunction(Harmonics(2, 2), np.linspace(-1.0, 1.0, 9), coordinates)
    np.testing.assert_allclose(
        tau.values(coordinates.forward(U)), Harmonics(2, 2).values(U) @ tau.coefficients, atol=1e-14
    )
    w, step = np.cross(U, [0.1, 0.7, 0.4]), 1e-5
    ahead, behind = (
        tau.values((U + s * w) / np.linalg.norm(U + s * w, axis=1)[:, None]) for s in (step, -step)
    )
    slope = np.einsum("ni,ni->n", tau.gradient(U), w)
    np.testing.assert_allclose((ahead - behind) / (2.0 * step), slope, atol=1e-8)
    np.testing.assert_allclose(np.einsum("ni,ni->n", tau.gradient(U), U), 0.0, atol=1e-14)
    back = TimeFunction(Harmonics(2, 2), tau.coefficients).in_coordinates(coordinates)
    np.testing.assert_allclose(
        back.values(U), Harmonics(2, 2).values(coordinates.forward(U)) @ tau.coefficients, atol=1e-6
    )


@pytest.mark.parametrize("a", [0.867, pytest.param(0.9, marks=pytest.mark.slow)])
def test_tilted_horizons_beyond_the_limit_are_refused(a):
    slice_ = KerrSchild(1.0, tuple(a * TILTED))
    data = StarSurface.from_radius(slice_.spheroid(slice_.horizon)).data(slice_, marginal=True)
    with pytest.raises(
        NotEmbedded, match=r"^with theta from the axis of symmetry \(0, 0\.6, 0\.8\), no surf"
    ):
        embed_surface(data, vertices=200)
