"""Reflections of vertices, and which are tried."""

import numpy as np
import pytest

import smooth_bodies
from isoembed.aim import vertex_reflections as module
from isoembed.aim.energy_descent import minimize_energy
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.schur_complement import Condensation
from isoembed.aim.vertex_reflections import PROMISE, SHALLOW, SIDE_RINGS, ReflectionTrials, reflections
from isoembed.gallery import Ellipsoid, HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric

MU = 1e-6


@pytest.fixture(scope="module")
def surface():
    """A minimum that misses its lengths."""
    vertices, faces = triangulate(HarmonicSurface(2, 2, 0.3), 150, irregular=1)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    errors = np.random.default_rng(0).standard_normal(metric.triangulation.n_edges)
    lengths, x = (
        metric.lengths * (1 + 1e-2 * errors),
        vertices / PolyhedralMetric.from_mesh(vertices, faces).unit,
    )
    energy = RegularizedEnergy(metric, vertices)
    for _ in range(4):
        x = minimize_energy(energy, x, lengths, MU, smooth_bodies.recorder(), lambda _: False)
    return Condensation(energy, x, lengths, MU, lambda _: None)


def never():
    """Go on."""
    return False


def test_a_reflection_is_in_the_plane_that_fits_the_neighbors():
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 100, irregular=2)
    triangulation = PolyhedralMetric.from_mesh(vertices, faces).triangulation
    moved = vertices + reflections(triangulation, vertices)
    for v in range(len(vertices)):
        rim = vertices[triangulation.adjacency[[v]].indices]
        middle = rim.mean(axis=0)
        normal = np.linalg.svd(rim - middle)[2][-1]
        height = (vertices[v] - middle) @ normal
        np.testing.assert_allclose(moved[v], vertices[v] - 2 * height * normal, atol=1e-12)


def test_shallow_vertices_change_the_lengths_little_and_to_the_better(surface):
    x, r = surface.vertices, surface.residuals
    moved = reflections(surface.energy.triangulation, x)
    promised = {}
    for v in range(len(x)):
        y = x.copy()
        y[v] += moved[v]
        d = surface.energy.residuals(y, surface.lengths) - r
        if PROMISE[0] < -(r @ d) / (r @ r) < PROMISE[1]:
            promised[v] = d @ d
    expected = sorted(promised, key=promised.__getitem__)[:SHALLOW]
    assert len(expected) > 0
    assert ReflectionTrials(surface, never)._shallow() == expected


def test_the_lengths_are_missed_most_at_centers_which_are_apart(surface):
    changes = ReflectionTrials(surface, never)
    centers = list(changes._largest_residuals(4))
    squares = surface.residuals**2
    around = [squares[surface.energy.triangulation.incidence[[v]].indices].sum() for v in range(150)]
    assert centers[0] == np.argmax(around)
    for i, center in enumerate(centers):
        assert not np.isin(centers[:i], changes._about(center, SIDE_RINGS)).any()


def test_what_promises_more_than_all_energy_is_not_believed(surface):
    for changes in ReflectionTrials(surface, never).singles(2):
        growths = [change.growth for change in changes]
        assert growths == sorted(growths)
        assert all(-surface.value < growth < 0 for growth in growths)


def test_nothing_is_tried_once_all_is_spent(surface):
    tried = []

    def is_done():
        tried.append(None)
        return len(tried) > 3

    for changes in ReflectionTrials(surface, is_done).singles(1):
        assert len(changes) <= 2
    assert len(tried) < 10


def test_shallow_vertices_that_are_tried_together_have_patches_apart(surface, monkeypatch):
    monkeypatch.setattr(module, "RINGS", 1)
    together = ReflectionTrials(surface, never).shallow()
    vertices = np.concatenate([change.patch.vertices for change in together])
    assert len(together) > 1
    assert len(np.unique(vertices)) == len(vertices)


def test_pairs_are_two_near_a_center(surface, monkeypatch):
    monkeypatch.setattr(module, "PATCHES", ((1, 2),))
    monkeypatch.setattr(module, "SIDE_RINGS", 1)
    (changes,) = ReflectionTrials(surface, never).pairs()
    (center,) = ReflectionTrials(surface, never)._largest_residuals(1)
    near = ReflectionTrials(surface, never)._about(center, 2)
    assert changes
    assert all(np.array_equal(change.patch.vertices, near) for change in changes)


def test_large_patches_are_left_out(surface, monkeypatch):
    monkeypatch.setattr(module, "LARGEST", 10)
    assert list(ReflectionTrials(surface, never).singles(2)) == [[], []]
