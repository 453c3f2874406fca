"""Wire frames from near and from a sphere."""

import numpy as np
import pytest

from isoembed.gallery import Ellipsoid
from isoembed.metric.curvature import area
from isoembed.smooth import PulledBack
from reproduction.baselines.subjects import Problem, paper_subjects, star_shaped
from reproduction.baselines.wire_frame import sphere_layout, wire_frame
from smooth_bodies import misfit

ROUND = PulledBack(lambda u: np.broadcast_to(2.0 * np.eye(3), (len(u), 3, 3)))
NEARLY_ROUND = star_shaped("nearly round", Ellipsoid((1.2, 1.1, 1.0)))


def test_a_wire_frame_near_the_true_surface_returns_to_it():
    problem = Problem.of(paper_subjects()[1], 100)
    shaken = problem.vertices + 0.01 * np.random.default_rng(1).standard_normal(problem.vertices.shape)
    found = wire_frame(problem.metric, shaken)
    assert found.converged
    assert misfit(found.vertices, problem.vertices) < 1e-9


def test_a_wire_frame_from_a_sphere_has_the_lengths_and_is_crumpled():
    problem = Problem.of(paper_subjects()[1], 200)
    found = wire_frame(problem.metric, sphere_layout(problem.metric))
    assert found.converged  # measured on the vertices
    assert misfit(found.vertices, problem.vertices) > 0.02
    assert found.surface.concave_edges.sum() > 120  # of 594; the true mesh has 100


def test_layouts_are_spheres_of_the_same_area_and_scale():
    problem = Problem.of(NEARLY_ROUND, 100)
    radii = np.linalg.norm(sphere_layout(problem.metric), axis=1)
    np.testing.assert_allclose(radii, radii[0], rtol=1e-12)
    assert 4 * np.pi * radii[0] ** 2 == pytest.approx(area(problem.metric), rel=1e-12)
    rough = sphere_layout(problem.metric, noise=0.3) - sphere_layout(problem.metric)
    assert rough.std() == pytest.approx(0.3 * problem.metric.mean_length, rel=0.1)
