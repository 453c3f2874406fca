"""Patches that move far, the rest following: their energy against that of the whole surface."""

import numpy as np
import pytest

import smooth_bodies
from isoembed.aim.energy_descent import minimize_energy
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.schur_complement import Condensation
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric

MU = 1e-4


def ignore(_):
    """Take what is spent."""


@pytest.fixture(scope="module")
def minimum():
    """An energy, lengths that no surface has, mu and a minimum."""
    vertices, faces = triangulate(HarmonicSurface(2, 2, 0.3), 150)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    errors = np.random.default_rng(0).standard_normal(metric.triangulation.n_edges)
    lengths = metric.lengths * (1 + 1e-3 * errors)
    energy, x = RegularizedEnergy(metric, vertices), vertices / metric.unit
    for _ in range(4):
        x = minimize_energy(energy, x, lengths, MU, smooth_bodies.recorder(), lambda _: False)
    return energy, lengths, x


def about(energy, center, rings):
    found = np.array([center])
    for _ in range(rings):
        found = np.union1d(found, energy.triangulation.adjacency[found].indices)
    return found


def test_the_energy_of_a_patch_of_all_vertices_is_exact(minimum):
    energy, lengths, x = minimum
    surface = Condensation(energy, x, lengths, MU, ignore)
    patch = surface.patch(np.arange(len(x)))
    motion = 0.3 * np.random.default_rng(1).standard_normal(x.shape)
    grown = energy.value(x + motion, lengths, MU) - surface.value
    assert patch.change(motion) == pytest.approx(grown, rel=1e-6)


def test_where_the_rest_follows_the_energy_is_right_to_second_order_and_least(minimum):
    energy, lengths, x = minimum
    surface = Condensation(energy, x, lengths, MU, ignore)
    patch = surface.patch(about(energy, 40, 1))
    forces = np.random.default_rng(1).standard_normal((len(patch.vertices), 3)).ravel()
    arms = x[patch.vertices]
    rigid = [np.cross(axis, arms).ravel() for axis in np.eye(3)] + [
        np.tile(axis, len(arms)) for axis in np.eye(3)
    ]
    rigid = np.linalg.qr(np.array(rigid).T)[0]
    forces -= rigid @ (rigid.T @ forces)  # in balance: nothing pulls at the triangle that holds the surface
    motion = np.linalg.solve(patch.stiffness, forces).reshape(-1, 3)
    motion /= np.abs(motion).max()
    errors = []
    for size in (4e-4, 2e-4, 1e-4):
        moved = x + patch.followed(size * motion)
        np.testing.assert_allclose(moved[patch.vertices], x[patch.vertices] + size * motion, atol=1e-14)
        grown = energy.value(moved, lengths, MU) - surface.value
        errors.append(abs(patch.change(size * motion) - grown) / grown)
        alone = x.copy()
        alone[patch.vertices] += size * motion
        assert grown < 0.9 * (energy.value(alone, lengths, MU) - surface.value)
    assert errors[0] < 0.1
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


def test_a_patch_relaxes_to_where_the_surface_does(minimum):
    (energy, lengths, x), spent = minimum, []
    surface = Condensation(energy, x, lengths, MU, spent.append)
    patch = surface.patch(about(energy, 40, 3))
    motion = np.zeros((len(patch.vertices), 3))
    motion[np.searchsorted(patch.vertices, 40)] = 0.05
    relaxed, growth = patch.relaxed(motion)
    assert growth < 1e-3 * patch.change(motion)
    assert patch.change(relaxed) == growth
    assert np.abs(relaxed).max() < 0.05 * 0.05  # it has fallen back
    assert 0 < sum(spent) < 10


def test_pushing_edges_are_left_out_where_they_would_make_it_indefinite(minimum):
    energy, lengths, x = minimum
    surface = Condensation(energy, 0.8 * x, lengths, MU, ignore)  # no minimum: all edges are too short
    assert surface.tensions.min() == 0.0
    assert (energy.residuals(0.8 * x, lengths) < 0).all()
