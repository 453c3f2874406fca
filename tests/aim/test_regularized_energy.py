"""The regularized energy: what it prefers, and that its steps are those of Gauss and Newton."""

import numpy as np
import pytest

import curved_bodies
import smooth_bodies
import zoo
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import edge_rows, length_residuals
from isoembed.surface.vertex_system import HeldTriangle


def normalized(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return metric.normalized, vertices / metric.unit


def test_the_roughness_is_a_positive_form_that_knows_no_translation():
    metric, x = normalized(*zoo.icosphere(2))
    energy = RegularizedEnergy(metric, x)
    rng = np.random.default_rng(0)
    y, z = rng.normal(size=x.shape), rng.normal(size=x.shape)
    assert np.sum(y * energy.roughness(z, 0.7)) == pytest.approx(
        np.sum(z * energy.roughness(y, 0.7)), rel=1e-10
    )
    assert np.sum(y * energy.roughness(y, 0.0)) > 0
    assert np.abs(energy.roughness(np.ones_like(x), 3.0)).max() < 1e-10


def test_spheres_and_smooth_bodies_are_hardly_rough():
    for n, most in ((300, 3e-2), (1200, 2e-3)):
        metric, x = normalized(*triangulate(CassiniPeanut(), n))
        energy = RegularizedEnergy(metric, x)
        assert np.sum(x * energy.roughness(x, 0.0)) < most  # falls with the seventh power of the edge length
        assert np.sum(x * energy.roughness(x, 1.0)) > 10 * most  # bending does not


@pytest.mark.parametrize("w", [0.0, 3.0])
def test_the_solver_solves_the_normal_equations(w):
    metric, x = normalized(*zoo.icosphere(2))
    energy, n = RegularizedEnergy(metric, x), x.size
    x = x + 0.05 * np.random.default_rng(1).normal(size=x.shape)
    rows = edge_rows(metric.triangulation, x, metric.lengths)
    mu = 0.1
    J = np.zeros((metric.triangulation.n_edges, len(x), 3))
    a, b = metric.edges.T
    J[np.arange(len(a)), a], J[np.arange(len(a)), b] = rows, -rows
    J = J.reshape(len(a), n)
    penalty = np.column_stack([energy.roughness(e.reshape(-1, 3), w).ravel() for e in np.eye(n)])
    wanted = np.random.default_rng(2).normal(size=x.shape)
    wanted -= wanted.mean(axis=0)
    gradient = (J.T @ J + mu * penalty) @ wanted.ravel()
    solved = energy.solver(x, metric.lengths, mu, w)(gradient.reshape(-1, 3))
    left = (J.T @ J + mu * penalty) @ solved.ravel() - gradient
    assert np.linalg.norm(left) < 2e-3 * np.linalg.norm(gradient)


def test_no_step_goes_uphill_and_at_the_minimum_none_is_made():
    metric, x = normalized(*smooth_bodies.ellipsoid())
    penalized, recorder, mu = RegularizedEnergy(metric, x), smooth_bodies.recorder(), 0.05
    y = x + 0.1 * np.random.default_rng(0).normal(size=x.shape)

    def energy(y):
        r = length_residuals(metric.triangulation, y, metric.lengths)
        return r @ r + mu * np.sum(y * penalized.roughness(y, 1.0))

    energies = [energy(y)]
    for _ in range(12):
        y = penalized.relaxed(y, metric.lengths, mu, 1.0, recorder)
        energies.append(energy(y))
    assert (np.diff(energies) <= 0).all()
    assert energies[-2] - energies[-1] < 1e-6 * energies[-1] < 1e-4 * energies[0]


@pytest.mark.parametrize(("curvature", "size"), [(-1.0, 2.0), (1.0, 1.2)])
def test_forces_and_rates_are_derivatives_in_curved_space(curvature, size):
    space = Space(curvature)
    x, faces = curved_bodies.smooth(space, CassiniPeanut(), 100, size)
    metric = curved_bodies.metric_of(space, x, faces)
    energy = RegularizedEnergy(metric, x)
    rng = np.random.default_rng(0)
    x, motion = x * (1 + 0.01 * rng.normal(size=(len(x), 1))), rng.normal(size=x.shape)
    h, lengths = 1e-6, metric.lengths
    before, after = (energy.residuals(x + s * h * motion, lengths) for s in (-1, 1))
    assert energy.rates(x, lengths, motion) == pytest.approx((after - before) / (2 * h), rel=1e-6, abs=1e-8)
    forces = energy.forces(x, lengths, energy.residuals(x, lengths))
    assert np.sum(forces * motion) == pytest.approx((after @ after - before @ before) / (4 * h), rel=1e-6)


@pytest.mark.parametrize(("curvature", "size"), [(-1.0, 2.0), (1.0, 1.2)])
def test_steps_in_curved_space_go_downhill_and_contain_no_isometry(curvature, size):
    space = Space(curvature)
    x, faces = curved_bodies.smooth(space, CassiniPeanut(), 100, size)
    metric = curved_bodies.metric_of(space, x, faces)
    energy, mu = RegularizedEnergy(metric, x), 0.1 * metric.mean_length**2
    start = x * (1 + 0.02 * np.random.default_rng(0).normal(size=(len(x), 1)))
    y, downhill = energy.step(start, metric.lengths, mu, 3.0, smooth_bodies.recorder())
    assert downhill
    surface = Projected.of(space, start)
    z = ((y - start) / surface.heights[:, None]).ravel()
    assert np.linalg.norm(surface.without_isometries()(z) - z) < 1e-9 * np.linalg.norm(z)
    # A small motion along what is left out changes no length.
    kept = np.random.default_rng(1).normal(size=z.size)
    isometry = surface.motion((kept - surface.without_isometries()(kept)).reshape(-1, 3))
    rates = energy.rates(start, metric.lengths, isometry)
    assert np.abs(rates).max() < 1e-12 * np.abs(isometry).max()


def test_what_is_solved_for_with_a_held_triangle_does_not_hang_on_which_it_is():
    metric, x = normalized(*triangulate(CassiniPeanut(), 150))
    energy, lengths = RegularizedEnergy(metric, x), metric.lengths
    forces = energy.forces(x, lengths, np.random.default_rng(0).standard_normal(len(lengths)))
    stretches = []
    for face in (0, 100):
        held = HeldTriangle.of(x, metric.faces[face])
        factor = energy.newton_factor(x, lengths, 1e-9, np.zeros(len(lengths)), held)
        stretches.append(energy.rates(x, lengths, factor.solve(forces.ravel()).reshape(-1, 3)))
    np.testing.assert_allclose(*stretches, atol=1e-6 * np.abs(stretches[0]).max())
