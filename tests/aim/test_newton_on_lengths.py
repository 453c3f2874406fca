"""Newton's method on the lengths: from near by at once, with the deviation from its branch, or not at all."""

import numpy as np

import smooth_bodies
from isoembed.aim.acceptance import REALIZED
from isoembed.aim.newton_on_lengths import least_residual_after_step, newton_on_lengths
from isoembed.aim.strategies import LENGTHS_DEVIATION
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem, length_residuals


def solved(share):
    """The solution from a surface that is bent by this share of an edge, and the exact vertices."""
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    metric, x = metric.normalized, vertices / metric.unit
    start = x + share * np.random.default_rng(0).normal(size=x.shape)
    recorder = smooth_bodies.recorder()
    system = LengthSystem(metric.triangulation, work=recorder.work)
    return newton_on_lengths(system, start, metric.lengths, REALIZED, recorder), x, recorder


def test_from_near_by_it_converges_on_its_branch():
    solution, x, recorder = solved(1e-3)
    assert smooth_bodies.misfit(solution.vertices, x) < 1e-9
    assert solution.branch_deviation < LENGTHS_DEVIATION
    assert recorder.factorizations == recorder.iterations <= 6


def test_an_exact_start_is_left_alone():
    solution, x, recorder = solved(0.0)
    assert solution.vertices is not None
    assert (solution.vertices == x).all()
    assert (solution.branch_deviation, recorder.iterations) == (0.0, 0)


def test_from_afar_it_does_not_converge():
    assert solved(1.0)[0] is None


def test_no_residual_after_a_step_is_below_the_bound():
    rng = np.random.default_rng(1)
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 100)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    system = LengthSystem(metric.triangulation)
    for share in (1e-3, 0.1, 0.5):
        x = vertices / metric.mean_length * np.exp(share * rng.normal(size=3))
        r = length_residuals(metric.triangulation, x, metric.lengths)
        after = length_residuals(metric.triangulation, x - system.step(x, metric.lengths, r), metric.lengths)
        assert least_residual_after_step(r, metric.lengths) <= np.abs(after).max()
    # A single edge shortened to a fraction s: the other equations let its ends move along it.
    s, length = 0.3, np.ones(1)
    r = (s**2 - 1) / 2 * length
    along = s - r / s  # e - d
    assert np.isclose(least_residual_after_step(r, length), (along**2 - 1) / 2)


def test_a_step_that_is_lost_is_not_taken():
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    recorder = smooth_bodies.recorder()
    system = LengthSystem(metric.triangulation, work=recorder.work)
    shrunk = 0.3 * vertices / np.mean(np.linalg.norm(np.diff(vertices[metric.edges], axis=1), axis=2))
    assert newton_on_lengths(system, shrunk, metric.lengths, REALIZED, recorder) is None
    assert recorder.factorizations == 0
