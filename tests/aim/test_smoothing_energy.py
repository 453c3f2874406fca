"""Factors that serve several steps of a fit: the same steps, fewer factorizations."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import isoembed
import sharp_bodies
import smooth_bodies
from isoembed.aim.adaptive import Aim
from isoembed.aim.best_fit import looks_noisy
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.smoothing_energy import SmoothingEnergy
from isoembed.embedding.fitted import FittedSurface
from isoembed.gallery import Bean, CassiniPeanut, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.alignment import distance
from isoembed.surface.piecewise_smoothness import creases, piecewise_fit_residuals
from isoembed.surface.projected import Projected


def scan(body, count, noise, seed=0):
    """A body with curvature of both signs, its metric, and that with normal errors of the lengths."""
    vertices, faces = triangulate(body, count)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    errors = noise * metric.mean_length * np.random.default_rng(seed).standard_normal(len(metric.lengths))
    return vertices, metric, metric.with_lengths(metric.lengths + errors)


def test_steps_are_those_of_the_energy_with_fewer_factorizations():
    vertices, _, metric = scan(CassiniPeanut(), 300, 1e-3)
    recorder, plain = smooth_bodies.recorder(), smooth_bodies.recorder()
    kept = SmoothingEnergy(metric, vertices, recorder.work)
    energy = RegularizedEnergy(metric, vertices, plain.work)
    mu = 10.0 * metric.mean_length**2
    x = kept.minimized(vertices, metric.lengths, mu, 1e-6, 6, recorder)
    y = energy.minimized(vertices, metric.lengths, mu, 1e-6, 6, plain)
    assert distance(x, y) < 1e-5
    assert recorder.factorizations < plain.factorizations


def test_steps_do_not_turn_the_surface():
    """R takes a rotation to that of ``R x``, which is not 0: the equations alone would let steps turn it."""
    vertices, _, metric = scan(CassiniPeanut(), 300, 1e-3)
    energy, mu = SmoothingEnergy(metric, vertices), 10.0 * metric.mean_length**2
    motions = Projected.of(metric.space, vertices).rigid_motions()
    r = energy.residuals(vertices, metric.lengths)
    gradient = energy.forces(vertices, metric.lengths, r) + mu * energy.roughness(vertices, 0.0)
    step = energy.solved(vertices, metric.lengths, gradient, mu, 0.0)
    assert np.abs(motions.T @ step.ravel()).max() < 1e-9 * np.linalg.norm(step)


@pytest.mark.parametrize("mu", [10.0, 0.1])
def test_a_rotated_start_has_the_rotated_fit_by_one_factorization(mu):
    vertices, _, metric = scan(CassiniPeanut(), 300, 1e-3)
    turn = Rotation.from_rotvec([0.3, -0.8, 1.1]).as_matrix()
    fits = []
    for start in (vertices, vertices @ turn.T):
        recorder = smooth_bodies.recorder()
        energy = SmoothingEnergy(metric, start, recorder.work)
        fits.append(energy.minimized(start, metric.lengths, mu * metric.mean_length**2, 0.01, 8, recorder))
        assert recorder.factorizations == 1
    assert np.abs(fits[1] - fits[0] @ turn.T).max() < 1e-6 * metric.mean_length


def test_factors_serve_when_one_length_is_left_out():
    vertices, _, metric = scan(CassiniPeanut(), 300, 1e-3)
    recorder = smooth_bodies.recorder()
    whole = SmoothingEnergy(metric, vertices, recorder.work)
    weights = np.ones(len(metric.lengths))
    weights[7] = 1e-3
    mu = 10.0 * metric.mean_length**2
    without = whole.weighted(weights)
    fits = [e.minimized(vertices, metric.lengths, mu, 0.01, 8, recorder) for e in (whole, without)]
    assert recorder.factorizations == 1
    alone = SmoothingEnergy(metric, vertices).weighted(weights)
    again = alone.minimized(vertices, metric.lengths, mu, 0.01, 8, recorder)
    assert distance(fits[1], again) < 1e-5 * metric.mean_length < distance(fits[1], fits[0])


def test_no_least_squares_solver_finds_less():
    vertices, _, metric = scan(CassiniPeanut(), 300, 3e-3)
    metric, vertices = metric.normalized, vertices / metric.unit
    energy, mu = SmoothingEnergy(metric, vertices), 1.0
    x = energy.minimized(vertices, metric.lengths, mu, 1e-4, 20, smooth_bodies.recorder())
    a, b = metric.edges.T
    R = energy.fit_residuals

    def residuals(flat):
        y = flat.reshape(-1, 3)
        d = np.linalg.norm(y[a] - y[b], axis=1)
        errors = (d**2 - metric.lengths**2) / (2 * metric.lengths)
        return np.concatenate([errors, np.sqrt(mu) * (R @ y).ravel()])

    reached = least_squares(
        residuals, x.ravel(), method="trf", jac_sparsity=None, max_nfev=3, tr_solver="lsmr"
    )
    value = energy.value(x, metric.lengths, mu)
    assert value == pytest.approx(np.sum(residuals(x.ravel()) ** 2), rel=1e-9)
    assert 2 * reached.cost > 0.999 * value


@pytest.mark.parametrize("noise", [0.0, 3e-3])
def test_noise_is_told_from_a_smooth_surface(noise):
    vertices, _, metric = scan(Bean(), 1200, noise)
    assert looks_noisy(metric, vertices) == (noise > 0)


def test_noisy_lengths_are_fitted_at_once():
    vertices, exact, metric = scan(Bean(), 1200, 3e-3)
    found = isoembed.embed(metric, method=Aim(best_fit=True))
    assert isinstance(found, FittedSurface)
    assert found.noise == pytest.approx(3e-3, rel=0.3)
    assert distance(found.vertices, vertices) < 0.3 * exact.mean_length
    assert not {"guided pull back", "local search"} & {stage.name for stage in found.stages}


@pytest.mark.slow
def test_smoothing_is_not_taken_for_a_blunder():
    """At the ends of the bean large weights miss several lengths by more than seven deviations."""
    vertices, exact, metric = scan(Bean(), 2000, 1e-3)
    found = isoembed.embed(metric, length_errors=1e-3 * exact.mean_length)
    assert found.converged
    assert distance(found.vertices, vertices) < 0.2 * exact.mean_length


@pytest.mark.parametrize("bulge", [0.02, 0.1])
def test_a_bulge_that_the_rim_of_a_flat_lid_allows_does_not_stop_the_fit(bulge):
    """A paraboloid that vanishes on a circle changes no length to first order, and is smooth."""
    true, faces = sharp_bodies.cylinder(1.2, 0.33, 0)
    metric = PolyhedralMetric.from_mesh(true, faces)
    vertices, lid = true.copy(), np.isclose(true[:, 2], 1.2)
    vertices[lid, 2] += bulge * (1 - np.sum(true[lid, :2] ** 2, axis=1))
    crease = next(creases(metric.triangulation, true))
    residuals = piecewise_fit_residuals(metric.triangulation, crease, vertices, degree=2)
    energy, mu = SmoothingEnergy(metric, vertices, None, residuals), 10.0 * metric.mean_length**2
    found = energy.minimized(vertices, metric.lengths, mu, 0.01, 8, smooth_bodies.recorder())
    assert energy.value(found, metric.lengths, mu) < 0.5 * energy.value(vertices, metric.lengths, mu)
