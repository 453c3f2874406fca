"""Harmonics fitted from round and bumpy spheres."""

import re

import numpy as np
import pytest

from isoembed import InvalidParameter
from isoembed.gallery import Ellipsoid
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth import Harmonics, PulledBack
from reproduction.baselines.isometry import IsometrySystem
from reproduction.baselines.spherical_harmonics import fit_harmonics, projected, sphere
from reproduction.baselines.subjects import Problem, paper_subjects, star_shaped
from reproduction.baselines.wire_frame import wire_frame
from smooth_bodies import misfit

ROUND = PulledBack(lambda u: np.broadcast_to(2.0 * np.eye(3), (len(u), 3, 3)))
NEARLY_ROUND = star_shaped("nearly round", Ellipsoid((1.2, 1.1, 1.0)), (1.2, 1.1, 1.0))


def test_starts_of_another_shape_are_refused():
    problem = Problem.of(NEARLY_ROUND, 30)
    with pytest.raises(InvalidParameter, match=re.escape("has the shape (29, 3), not (30, 3)")):
        wire_frame(problem.metric, problem.vertices[:-1])
    with pytest.raises(InvalidParameter, match=re.escape("has the shape (4, 3), not (9, 3)")):
        fit_harmonics(ROUND, Harmonics(2, 2), np.zeros((4, 3)))
    with pytest.raises(InvalidParameter, match="order 0 hold no sphere"):
        sphere(ROUND, Harmonics(2, 0))


def test_the_sphere_is_a_start_of_the_same_area_with_bumps_of_the_given_size():
    u = fibonacci_directions(2000)
    harmonics = Harmonics(6, 6)
    smooth, bumpy = (sphere(ROUND, harmonics, size, seed=2) for size in (0.0, 0.3))
    np.testing.assert_allclose(harmonics.values(u) @ smooth, 2.0 * u, atol=1e-13)
    away = harmonics.values(u) @ (bumpy - smooth)
    assert np.sqrt((away**2).sum(axis=1).mean()) == pytest.approx(0.3 * 2.0, rel=1e-2)


def test_harmonics_find_what_they_contain():
    # In its own coordinates the ellipsoid is linear.
    metric = PulledBack(lambda u: np.broadcast_to(np.diag([3.0, 2.0, 1.0]), (len(u), 3, 3)))
    harmonics = Harmonics(3, 3)
    found = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    u = fibonacci_directions(50)
    assert found.settled
    assert misfit(found.points(u), u * [3.0, 2.0, 1.0]) < 1e-6


def test_harmonics_end_where_gauss_newton_steps_end():
    # With few harmonics strains are left, and a wrong slope would show in their least sum of squares.
    metric, harmonics = paper_subjects()[1].metric, Harmonics(4, 4)
    found = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    again = IsometrySystem.of(metric, harmonics).fitted(found.coefficients)
    u = fibonacci_directions(50)
    assert found.strain > 0.1
    assert misfit(found.points(u), harmonics.values(u) @ again) < 1e-5


def test_harmonics_converge_spectrally_from_the_sphere():
    strains = []
    for degree in (2, 4, 6, 8):
        harmonics = Harmonics(degree, degree)
        start = sphere(NEARLY_ROUND.metric, harmonics)
        strains.append(fit_harmonics(NEARLY_ROUND.metric, harmonics, start).strain)
    factors = np.array(strains[1:]) / strains[:-1]
    assert (factors < 0.1).all()  # two degrees more, one digit more


def test_harmonics_get_stuck_from_some_bumpy_spheres_and_not_from_others():
    metric, harmonics = paper_subjects()[1].metric, Harmonics(8, 8)
    round_one = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    found = [fit_harmonics(metric, harmonics, sphere(metric, harmonics, 0.5, seed)) for seed in range(4)]
    worse = [one.settled and one.strain > 2.0 * round_one.strain for one in found]
    assert 0 < sum(worse) < 4


def test_projection_is_exact_where_it_can_be():
    u = fibonacci_directions(40)
    harmonics = Harmonics(2, 2)
    C = np.random.default_rng(0).standard_normal((harmonics.size, 3))
    np.testing.assert_allclose(projected(harmonics.values(u) @ C, u, harmonics), C, atol=1e-12)
