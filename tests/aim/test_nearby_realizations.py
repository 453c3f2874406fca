"""Neighboring realizations, and how far realizations are apart."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_realizations import nearby_realizations, predicted_motions, softest_motions
from isoembed.gallery import Bean, Ergosphere, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.alignment import distance
from isoembed.surface.rigidity import LengthSystem, length_residuals


def realization(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    normalized = metric.normalized
    return LengthSystem(metric.triangulation), vertices / metric.unit, normalized.lengths


def found(system, x, lengths):
    return nearby_realizations(system, x, lengths, smooth_bodies.recorder(), residual_tolerance=1e-11)


@pytest.mark.parametrize(
    ("surface", "n", "irregular"),
    [(Bean(), 400, None), pytest.param(Bean(), 1000, 1, marks=pytest.mark.slow)],
)
def test_from_a_neighbor_the_smooth_surface_is_found_again(surface, n, irregular):
    system, x, lengths = realization(*triangulate(surface, n, irregular=irregular))
    first, *others = found(system, x, lengths)
    assert distance(first, x) < 1e-9  # the surface that the lengths were taken from is the smoothest
    assert others
    for other in others:
        assert np.abs(length_residuals(system.triangulation, other, lengths)).max() < 1e-11
        assert distance(other, x) > 1e-6
        again, *_ = found(system, other, lengths)
        assert distance(again, x) < 1e-9


def test_a_search_ends_at_the_first_step_that_does_not_halve_the_residual():
    system, x, lengths = realization(*triangulate(Ergosphere(epsilon=0.5), 400, irregular=0))
    recorder = smooth_bodies.recorder()
    system = LengthSystem(system.triangulation, work=recorder.work)
    assert len(nearby_realizations(system, x, lengths, recorder, residual_tolerance=1e-11)) == 1
    assert recorder.factorizations == 2  # for the softest motions, and of one step


def test_no_motion_leads_to_the_same_realization():
    # Within rounding of a realization, a root of the equations leads back to it: it hid the other one.
    system, x, lengths = realization(*triangulate(Bean(), 400))
    soft = softest_motions(LengthExpansion(system, x, lengths), 4)
    near = x + 3e-10 * soft[0] / np.abs(soft[0]).max()
    expansion = LengthExpansion(system, near, lengths)
    assert np.abs(expansion.residuals).max() < 1e-11
    motions = predicted_motions(expansion, soft, 0.03).motions
    assert motions
    assert min(np.linalg.norm(each, axis=1).max() for each in motions) > 1e-6


def test_from_between_two_neighbors_one_is_found():
    system, x, lengths = realization(*triangulate(Bean(), 400))
    _, other, *_ = found(system, x, lengths)
    between = 0.95 * x + 0.05 * other
    assert np.abs(length_residuals(system.triangulation, between, lengths)).max() > 1e-11
    first, *_ = found(system, between, lengths)
    assert min(distance(first, x), distance(first, other)) < 1e-9


@pytest.mark.parametrize("mesh", [zoo.icosahedron(), zoo.icosphere(2), zoo.random_hull(30, 0)])
def test_convex_bodies_are_alone(mesh):
    system, x, lengths = realization(*mesh)
    assert len(found(system, x, lengths)) == 1


def test_a_surface_that_flexes_has_none_to_be_found():
    vertices, faces = zoo.icosphere(1)
    system, _, lengths = realization(vertices, faces)
    assert found(system, vertices * [1, 1, 0], lengths) == []


def test_the_distance_forgets_motions():
    vertices, _ = zoo.random_hull(20, 1)
    moved = vertices @ zoo.rotation(3) + [1.0, -2.0, 0.5]
    assert distance(vertices, moved) < 1e-14
    moved[7] += [0.0, 0.0, 1e-3]
    assert 5e-4 < distance(vertices, moved) < 1e-3
    # A mirror image is another placement.
    assert distance(vertices, vertices * [1, 1, -1]) > 0.1
