"""The Wang-Yau energy of surfaces of Minkowski space, which is zero, and its invariances."""

from dataclasses import replace

import numpy as np
import pytest

from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import SurfaceData, TimeFunction, wang_yau
from isoembed.relativity.energies import wang_yau_search
from spacelike import directions, minkowski


@pytest.fixture
def few_harmonics(monkeypatch):
    """Fewer harmonics of X than by default, which are enough here."""
    monkeypatch.setattr(wang_yau_search, "DEGREES", (12, 12))


def test_zero_for_surfaces_of_minkowski_space():
    surface, data, embedding = minkowski()
    found = wang_yau(data, surface.tau, embedding=embedding)
    assert abs(found.energy.value) < 1e-12
    assert found.gradient < 1e-12
    assert found.admissible > 0.1
    # Up to a motion the embedding is the surface itself.
    a, b = found.embedding.points(directions()), surface.X.values(directions())
    np.testing.assert_allclose(
        np.linalg.norm(a[:, None] - a, axis=2), np.linalg.norm(b[:, None] - b, axis=2), atol=1e-11
    )
    assert wang_yau(data, embedding=embedding).energy.value > 1e-3


@pytest.mark.usefixtures("few_harmonics")
def test_the_sign_of_the_connection_matters():
    surface, _, embedding = minkowski()
    assert wang_yau(surface.data(-1.0), surface.tau, embedding=embedding).energy.value < -1e-3


@pytest.mark.slow
@pytest.mark.usefixtures("few_harmonics")
def test_found_from_zero_up_to_a_boost():
    surface, data, embedding = minkowski()
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(2, 4))
    assert abs(found.energy.value) < 1e-10
    assert found.gradient < 1e-7
    assert not found.notes
    assert found.embeddings <= 15
    u, _ = gauss_rule(10, 20)
    motions = np.column_stack([np.ones(len(u)), surface.tau.values(u), surface.X.values(u)])
    tau = found.tau.values(u)
    by, *_ = np.linalg.lstsq(motions, tau, rcond=None)
    assert np.abs(motions @ by - tau).max() < 1e-5
    # A boost: the row (T0, T) of a Lorentz transformation.
    assert by[1] ** 2 - by[2:] @ by[2:] == pytest.approx(1.0, abs=1e-4)
    assert np.abs(tau).max() > 0.1


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.slow
def test_norm_and_connection_do_instead_of_a_slice():
    surface, data, embedding = minkowski()

    def norm(u):
        k, p, _ = surface.lying(u)
        return np.sqrt(k**2 - p**2)

    def angle(u):
        k, p, _ = surface.lying(u)
        return np.arctanh(p / k)

    psi = TimeFunction.of(angle, 32)
    bare = SurfaceData(
        surface, mean_curvature=norm, normal_momentum=lambda u: surface.lying(u)[2] - psi.gradient(u)
    )
    tau = TimeFunction(surface.tau.harmonics, 0.7 * surface.tau.coefficients[::-1])
    one, other = (wang_yau(d, tau, embedding=embedding).energy.value for d in (data, bare))
    assert one == pytest.approx(other, rel=1e-9)
    wrong = replace(bare, normal_momentum=None)
    assert wang_yau(wrong, tau, embedding=embedding).energy.value != pytest.approx(one, rel=1e-3)


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.slow
def test_rotations_are_free():
    surface, data, embedding = minkowski()
    Q, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    Q *= np.linalg.det(Q)

    class Turned:
        def tensor(self, u):
            return Q @ surface.tensor(u @ Q) @ Q.T

    turned = SurfaceData(
        Turned(),
        mean_curvature=lambda u: data.mean_curvature(u @ Q),
        momentum=lambda u: data.momentum(u @ Q),
        normal_momentum=lambda u: data.normal_momentum(u @ Q) @ Q.T,
    )
    tau = TimeFunction.of(lambda u: 0.2 * u[:, 0] * u[:, 2] - 0.1 * u[:, 1], 2)
    one = wang_yau(data, tau, embedding=embedding)
    other = wang_yau(turned, TimeFunction.of(lambda u: tau.values(u @ Q), 2))
    assert other.energy.value == pytest.approx(one.energy.value, rel=1e-8)


@pytest.mark.usefixtures("few_harmonics")
def test_the_embedding_lies_in_minkowski_space():
    surface, data, embedding = minkowski()
    found = wang_yau(data, lambda u: 0.2 * u[:, 2] + 0.1 * u[:, 0] * u[:, 2], embedding=embedding)
    u = directions()
    dX = found.embedding.harmonics.gradients(u)[1] @ found.embedding.coefficients
    slope = found.tau.gradient(u)
    induced = np.einsum("nic,njc->nij", dX, dX) - slope[:, :, None] * slope[:, None, :]
    np.testing.assert_allclose(induced, surface.tensor(u), atol=1e-6)
