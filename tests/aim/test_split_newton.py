"""Newton steps split into smooth and rough motions."""

import numpy as np
import pytest
from scipy.sparse import eye_array

import smooth_bodies
from isoembed.aim import split_newton
from isoembed.aim.split_newton import SplitNewton
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolated_rigidity import InterpolatedRigidity
from isoembed.surface.interpolation import Stencils
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.smoothness import QuinticResiduals


@pytest.fixture(scope="module")
def peanut():
    """The equations for its lengths, its vertices, how it is interpolated (twice), and the coarse factor."""
    x, faces = triangulate(CassiniPeanut(), 300)
    metric = PolyhedralMetric.from_mesh(x, faces)
    x, metric = x / metric.unit, metric.normalized
    triangulation = metric.triangulation
    sphere = x / np.linalg.norm(x, axis=1)[:, None]
    cells = VertexCells.of(triangulation, metric.lengths, sphere, 60)
    stencils = Stencils(cells, cells.triangulation(sphere))
    edges = InterpolatedRigidity(triangulation, stencils)
    P, differences = edges.interpolated(x)
    rows = (differences @ x[cells.vertices]) / metric.lengths[edges.edges][:, None]
    coarse = edges.factor(differences, rows, 1e-6 * eye_array(len(cells.vertices), format="csr"))
    weights = stencils.interpolation(x, faces, np.arange(len(x)), cells.of_vertex)
    return LengthSystem(triangulation), metric.lengths, x, weights, P, coarse, cells


def dense_rows(system, lengths, x):
    rows, (a, b) = edge_rows(system.triangulation, x, lengths), system.triangulation.edges.T
    J = np.zeros((len(a), len(x), 3))
    J[np.arange(len(a)), a], J[np.arange(len(a)), b] = rows, -rows
    return J.reshape(len(a), -1)


def test_a_step_is_that_of_least_squares_in_both_unknowns(peanut, monkeypatch):
    system, lengths, truth, weights, P, coarse, cells = peanut
    monkeypatch.setattr(split_newton, "SOLVED", 1e-10)
    monkeypatch.setattr(split_newton, "MAX_ITERATIONS", 2000)
    rng, mu = np.random.default_rng(0), 1e-2
    z = truth[cells.vertices] * [1.02, 1.0, 0.99]
    x = P @ z + 1e-3 * rng.normal(size=truth.shape)
    found, next_z = SplitNewton(system, lengths, P, coarse).step(x, z, mu, smooth_bodies.recorder())
    J, r = dense_rows(system, lengths, x), length_residuals(system.triangulation, x, lengths)
    wide = np.kron(weights.toarray(), np.eye(3))
    held = np.sqrt(mu) * np.hstack([np.eye(x.size), -wide])
    A = np.vstack([np.hstack([J, np.zeros((len(J), z.size))]), held])
    b = np.concatenate([J @ x.ravel() - r, np.zeros(x.size)])
    expected = np.linalg.lstsq(A, b, rcond=1e-12)[0][: x.size].reshape(-1, 3)
    rates = J @ (found - expected).ravel()  # rigid motions are nobody's
    assert np.abs(rates).max() < 1e-6
    rough = (found - P @ next_z).ravel()
    left = J @ (found - x).ravel() + r
    np.testing.assert_allclose(J.T @ left + mu * rough, 0.0, atol=1e-7)


def test_quintics_hold_the_smooth_surface_among_its_neighbors(peanut):
    system, lengths, truth, _, P, coarse, _ = peanut
    rng, recorder = np.random.default_rng(1), smooth_bodies.recorder()
    x = truth * [1.001, 1.0, 0.9995] + 3e-3 * rng.normal(size=truth.shape)
    system = LengthSystem(system.triangulation, work=recorder.work)
    newton = SplitNewton(system, lengths, P, coarse)
    quintics = QuinticResiduals.of(system.triangulation, truth)
    for mu in (1e-2, 1e-3, 1e-4, 1e-6, 1e-8):
        x = newton.smooth_step(x, quintics, mu, recorder)
    assert np.abs(length_residuals(system.triangulation, x, lengths)).max() < 1e-6
    assert smooth_bodies.misfit(x, truth) < 1e-4
    assert recorder.factorizations == 5


@pytest.mark.parametrize(("many", "least", "most"), [(1000, 1e-3, 1e-2), (100, 0.0, 1e-3)])
def test_steps_of_many_vertices_are_solved_for_more_exactly(peanut, monkeypatch, many, least, most):
    system, lengths, truth, _, P, coarse, _ = peanut
    monkeypatch.setattr(split_newton, "MANY", many)
    x, mu = truth + 3e-3 * np.random.default_rng(2).normal(size=truth.shape), 1e-4
    quintics = QuinticResiduals.of(system.triangulation, truth)
    found = SplitNewton(system, lengths, P, coarse).smooth_step(x, quintics, mu, smooth_bodies.recorder())
    J, r = dense_rows(system, lengths, x), length_residuals(system.triangulation, x, lengths)
    before = J.T @ r + mu * quintics.pull(x).ravel()
    after = J.T @ (r + J @ (found - x).ravel()) + mu * quintics.pull(found).ravel()
    assert least < np.linalg.norm(after) / np.linalg.norm(before) <= most * (1 + 1e-4)
